// The path of a hand through a room.
#include <palpate/study/room_path.h>

#include <gmock/gmock.h>

#include <palpate/base/error.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/study/procedural.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

/// A box of 0.3 x 0.2 x 0.16 m, 1.2 m up.
struct Room {
  Room() : index(made(), {}, raised()) {
    FilterReport report;
    kept = filter_scene(made(), {}, raised(), report);
    options.home.position = {0.0, 0.0, 1.4};
    options.reach = {Vector3d(-0.6, -0.6, 0.9), Vector3d(0.6, 0.6, 1.6)};
    options.touches = 3;
  }
  static GaussianScene made() { return make_scene(*make_surface("box"), {}); }
  static Similarity raised() {
    Similarity world_from_scene;
    world_from_scene.translation.z() = 1.2;
    return world_from_scene;
  }

  SceneIndex index;
  EllipsoidScene kept;
  Tool tool{Vector3d::Constant(0.02)};
  RoomPathOptions options;
};

std::size_t contacts(const Room& room, const Pose& pose) {
  ContactSet found;
  query(room.index, room.tool, pose, found);
  return found.contacts.size();
}

TEST(RoomPath, TouchesInItsTimesAndNowhereElse) {
  const Room room;
  const RoomPath made = room_path(room.index, room.kept, room.tool, room.options);
  ASSERT_EQ(made.touches.size(), 3U);
  std::size_t k = 0;
  for (const TimedPose& p : made.path) {
    while (k < 3 && p.t > made.touches[k].ends) ++k;
    if (k == 3 || p.t < made.touches[k].begins) {
      EXPECT_LT(contacts(room, p.pose), 3U) << p.t;
    }
  }
  for (const RoomTouch& touch : made.touches) {
    EXPECT_GT(contacts(room, pose_at(made.path, 0.5 * (touch.pressed + touch.slides))), 3U);
    EXPECT_NEAR((pose_at(made.path, touch.pressed).position - touch.place.touch.position).norm(),
                room.options.press, 1e-3);
    EXPECT_NEAR(touch.slides - touch.pressed, room.options.hold, 2e-3);
    EXPECT_LT(contacts(room, touch.place.touch), 6U);  // it only just touches
  }
}

TEST(RoomPath, MovesAsAHandDoesAndStaysInReach) {
  const Room room;
  const RoomPath made = room_path(room.index, room.kept, room.tool, room.options);
  for (std::size_t i = 1; i < made.path.size(); ++i) {
    const Vector3d way = made.path[i].pose.position - made.path[i - 1].pose.position;
    const double dt = made.path[i].t - made.path[i - 1].t;
    EXPECT_NEAR(dt, 1e-3, 1e-9);
    EXPECT_LE(way.norm(), 0.501 * dt);
    EXPECT_TRUE(room.options.reach.contains(made.path[i].pose.position));
    EXPECT_TRUE(made.path[i].pose.orientation.isApprox(room.options.home.orientation));
  }
  EXPECT_TRUE(made.path.front().pose.position.isApprox(room.options.home.position));
}

TEST(RoomPath, AnotherSeedIsAnotherPath) {
  Room room;
  const RoomPath first = room_path(room.index, room.kept, room.tool, room.options);
  room.options.seed = 2;
  const RoomPath second = room_path(room.index, room.kept, room.tool, room.options);
  EXPECT_GT((first.touches[0].place.touch.position - second.touches[0].place.touch.position).norm(), 1e-3);
}

TEST(RoomPath, SaysWhereNothingIsInReach) {
  Room room;
  room.options.reach = {Vector3d(-0.6, -0.6, 1.55), Vector3d(0.6, 0.6, 1.6)};
  try {
    room_path(room.index, room.kept, room.tool, room.options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("only 0 places"));
    EXPECT_THAT(error.what(), testing::HasSubstr("z 1.55 to 1.60 m"));
  }
}

}  // namespace
}  // namespace palpate

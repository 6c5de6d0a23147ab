#include <palpate/scene/scene_setup.h>

#include <array>
#include <random>
#include <utility>

#include <gmock/gmock.h>

#include <palpate/base/error.h>
#include <palpate/scene/lint.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

/// A floor of 1 m x 1 m, with a ball of 0.3 m on it, in a captured frame in which `up` is upward.
class Room {
 public:
  explicit Room(const Eigen::Quaterniond& captured_from_world = Eigen::Quaterniond::Identity(),
                double unit = 1.0)
      : turn_(captured_from_world), unit_(unit) {
    std::uniform_real_distribution<double> anywhere(-0.5, 0.5);
    for (int i = 0; i < 4000; ++i)
      add({anywhere(engine_), anywhere(engine_), 0.0}, Vector3d::UnitZ(), kSigma, 0.9);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 3000; ++i) {
      const Vector3d out = Vector3d{normal(engine_), normal(engine_), normal(engine_)}.normalized();
      add(Vector3d(0.0, 0.0, 0.3) + 0.3 * out, out, kSigma, 0.9);
    }
  }

  /// A disc at `position` that faces along `normal`.
  void add(const Vector3d& position, const Vector3d& normal, double sigma, double opacity) {
    Gaussian g;
    g.position = unit_ * (turn_ * position);
    g.rotation = turn_ * Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), normal);
    g.sigma = unit_ * Vector3d(sigma, sigma, 0.02 * sigma);
    g.opacity = opacity;
    scene_.append(g, {200, 200, 200});
  }

  const GaussianScene& scene() const { return scene_; }
  static constexpr double kSigma = 0.01;

 private:
  Eigen::Quaterniond turn_;
  double unit_;
  std::mt19937 engine_{7};
  GaussianScene scene_;
};

TEST(SceneSetup, FindsTheAxisThatPointsUp) {
  for (const UpAxis axis :
       {UpAxis::kXDown, UpAxis::kXUp, UpAxis::kYDown, UpAxis::kYUp, UpAxis::kZDown, UpAxis::kZUp}) {
    const Room room(upright(axis).conjugate());
    EXPECT_EQ(propose_setup(room.scene(), 0.02).frame.value, axis) << to_string(axis);
  }
}

// What no camera saw: together they have more area than the ball.
TEST(SceneSetup, IsNotMisledByAFewLargeGaussiansBeneathTheGround) {
  Room captured(upright(UpAxis::kYDown).conjugate());
  for (int i = 0; i < 200; ++i)
    captured.add({0.002 * i - 0.2, 0.0, -0.1 - 0.001 * i}, Vector3d::Ones(), 5 * Room::kSigma, 0.9);
  EXPECT_EQ(propose_setup(captured.scene(), 0.02).frame.value, UpAxis::kYDown);
}

TEST(SceneSetup, LeavesWhatFacesAllWaysAsItIs) {
  std::mt19937 engine(3);
  std::normal_distribution<double> normal;
  GaussianScene scene;
  for (int i = 0; i < 5000; ++i) {
    const Vector3d out = Vector3d{normal(engine), normal(engine), normal(engine)}.normalized();
    Gaussian g;
    g.position = out;
    g.rotation = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), out);
    g.sigma << 0.02, 0.02, 0.0005;
    g.opacity = 0.9;
    scene.append(g, {0, 0, 0});
  }
  EXPECT_EQ(propose_setup(scene, 0.02).frame.value, UpAxis::kAsIs);
}

// Upside down it is the same scene: nothing tells which way is up.
TEST(SceneSetup, LeavesWhatIsTheSameUpsideDownAsItIs) {
  Room room(upright(UpAxis::kYDown).conjugate());
  for (int i = 0; i < 100; ++i)
    for (int k = 0; k < 40; ++k)
      room.add({0.01 * i - 0.5, 0.025 * k - 0.5, 0.6}, Vector3d::UnitZ(), Room::kSigma, 0.9);
  const SceneSetup ceiling = propose_setup(room.scene(), 0.02);
  EXPECT_EQ(ceiling.frame.value, UpAxis::kAsIs);
  EXPECT_THAT(ceiling.frame.reason, HasSubstr("faces along y"));
  GaussianScene plane;
  Gaussian g;
  g.rotation.setIdentity();
  g.sigma << 0.01, 0.01, 0.0005;
  g.opacity = 0.9;
  for (int i = 0; i < 40; ++i) {
    for (int k = 0; k < 25; ++k) {
      g.position << 0.01 * i, 0.01 * k, 0.0;
      plane.append(g, {0, 0, 0});
    }
  }
  EXPECT_EQ(propose_setup(plane, 0.02).frame.value, UpAxis::kAsIs);
}

// Seven Gaussians across a tool of 20 mm are 2.9 mm each: 0.29 of 10 mm, whatever the unit.
TEST(SceneSetup, ScalesTheUsualGaussianToTheTool) {
  EXPECT_NEAR(propose_setup(Room().scene(), 0.02).scale.value, 0.29, 1e-9);
  EXPECT_NEAR(propose_setup(Room().scene(), 0.002).scale.value, 0.029, 1e-9);
  const Room in_feet(Eigen::Quaterniond::Identity(), 3.28);
  EXPECT_NEAR(propose_setup(in_feet.scene(), 0.02).scale.value, 0.087, 1e-9);
}

// What is printed is to be pasted: 1.9, not 1.9000000000000001.
TEST(SceneSetup, RoundsTheScaleToTwoDigits) {
  for (const double scale : {0.0067, 0.58, 1.9, 19.0, 190.0, 1900.0}) {
    const Room room(Eigen::Quaterniond::Identity(),
                    (0.02 / SceneSetup::kGaussiansAcross) / (Room::kSigma * scale));
    EXPECT_EQ(propose_setup(room.scene(), 0.02).scale.value, scale);
  }
}

TEST(SceneSetup, CutsHazeWhereThatCostsLittleOfWhatIsSeen) {
  Room hazy;
  for (int i = 0; i < 200; ++i) hazy.add({0.002 * i - 0.2, 0.0, 0.9}, Vector3d::UnitX(), Room::kSigma, 0.25);
  EXPECT_EQ(propose_setup(hazy.scene(), 0.02).opacity_min.value, 0.3);
  Room thin;  // a third of what is seen
  for (int i = 0; i < 12000; ++i) thin.add({1e-4 * i - 0.5, 0.0, 0.9}, Vector3d::UnitX(), Room::kSigma, 0.25);
  EXPECT_EQ(propose_setup(thin.scene(), 0.02).opacity_min.value, 0.2);
}

TEST(SceneSetup, FindsGiantsAndWhatIsFarAway) {
  const SceneSetup clean = propose_setup(Room().scene(), 0.02);
  EXPECT_FALSE(clean.max_scale.value);
  EXPECT_FALSE(clean.crop_box.value);
  Room captured(upright(UpAxis::kYDown).conjugate());
  for (int i = 0; i < 5; ++i) captured.add({0.0, 0.0, 0.3}, Vector3d::UnitX(), 0.6, 0.9);
  for (int i = 0; i < 5; ++i) captured.add({0.0, 0.0, 40.0 + i}, Vector3d::UnitX(), Room::kSigma, 0.9);
  const SceneSetup setup = propose_setup(captured.scene(), 0.02);
  ASSERT_TRUE(setup.max_scale.value);
  EXPECT_GE(*setup.max_scale.value, 0.29 * Room::kSigma);
  EXPECT_LT(*setup.max_scale.value, 0.29 * 0.6);
  EXPECT_THAT(setup.max_scale.reason, HasSubstr("5 Gaussians"));
  ASSERT_TRUE(setup.crop_box.value);
  EXPECT_THAT(setup.crop_box.reason, HasSubstr("5 Gaussians"));
  // In the world, where up is z: all of the room, and nothing of what is 40 m above it.
  EXPECT_TRUE(setup.crop_box.value->contains(0.29 * Vector3d(0.49, -0.49, 0.6)));
  EXPECT_LT(setup.crop_box.value->max().z(), 0.29 * 2.0);
}

// Sizes that are spread as in captures: what is a sixth of the scene is no outlier of theirs, but a wall to a
// hand.
TEST(SceneSetup, NamesAGiantWhereSizesAreSpread) {
  Room captured;
  for (int i = 0; i < 6000; ++i)
    captured.add({1e-4 * i - 0.3, 0.2, 0.1}, Vector3d::UnitX(), Room::kSigma * (i % 2 == 0 ? 0.1 : 3), 0.9);
  EXPECT_FALSE(propose_setup(captured.scene(), 0.02).max_scale.value);
  for (int i = 0; i < 5; ++i) captured.add({0.0, 0.0, 0.3}, Vector3d::UnitX(), 0.25, 0.9);
  EXPECT_EQ(lint(captured.scene()).giant, 5U);
  EXPECT_THAT(propose_setup(captured.scene(), 0.02).max_scale.reason, HasSubstr("5 Gaussians"));
}

TEST(SceneSetup, RefusesASceneOfNothing) {
  GaussianScene nothing;
  nothing.source = "nothing.ply";
  EXPECT_THROW(propose_setup(nothing, 0.02), Error);
}

TEST(UpAxis, BecomesWorldUp) {
  const std::array<std::pair<UpAxis, Vector3d>, 6> axes{{{UpAxis::kXUp, {1, 0, 0}},
                                                         {UpAxis::kXDown, {-1, 0, 0}},
                                                         {UpAxis::kYUp, {0, 1, 0}},
                                                         {UpAxis::kYDown, {0, -1, 0}},
                                                         {UpAxis::kZUp, {0, 0, 1}},
                                                         {UpAxis::kZDown, {0, 0, -1}}}};
  for (const auto& [axis, up] : axes)
    EXPECT_NEAR((upright(axis) * up - Vector3d::UnitZ()).norm(), 0.0, 1e-15) << to_string(axis);
}

}  // namespace
}  // namespace palpate

// What runs in the servo loop takes nothing from the heap.

#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/contact_tracker.h>
#include <support/allocation_guard.h>
#include <support/on_every_target.h>
#include <support/random_scenes.h>

namespace palpate {
namespace {

using test::AllocationGuard;
using test::scene_of;
using test::splat;
using test::Splat;

class QueryAllocation : public test::OnEveryTarget {
 protected:
  /// From far away into the scene and out again.
  static std::vector<Ellipsoid> path() {
    test::Random random(401);
    std::vector<Ellipsoid> tools;
    for (int i = -300; i <= 300; ++i)
      tools.push_back(Ellipsoid::from_semi_axes({{5e-3 * i, 0, 0}, random.rotation()}, {0.2, 0.2, 0.3}));
    return tools;
  }

  /// More contacts than one buffer of pairs, and than a tracker keeps, in the middle.
  static GaussianScene scene() {
    test::Random random(402);
    std::vector<Splat> splats;
    for (int i = 0; i < 3000; ++i) {
      const Eigen::Vector3d at = random.in_box(0.2), semi_axes = random.semi_axes(1e-3, 0.05);
      splats.push_back(splat(at, semi_axes, random.rotation()));
    }
    splats.push_back(splat({0, 0, 0}, {0.1, 0.1, 0.0}));  // a coincident centre goes to the scalar code
    return scene_of(splats);
  }
};

TEST_F(QueryAllocation, ANewVectorIsCounted) {
  const AllocationGuard guard;
  const std::vector<int> on_the_heap(100);
  // A compiler may leave out what nobody sees.
  [[maybe_unused]] const void* volatile seen = on_the_heap.data();
  EXPECT_EQ(guard.count(), 1U);
}

TEST_F(QueryAllocation, SceneIndexTakesNothingOnceTheResultHasRoom) {
  const SceneIndex index(scene(), {}, {});
  const std::vector<Ellipsoid> tools = path();
  on_every_target([&] {
    ContactSet set;
    set.contacts.reserve(3001);
    std::size_t most = 0;
    const AllocationGuard guard;
    for (const Ellipsoid& tool : tools) {
      index.query(tool, set);
      most = std::max(most, set.contacts.size());
    }
    const std::size_t count = guard.count();
    EXPECT_EQ(count, 0U);
    EXPECT_GT(most, 1024U);
    EXPECT_TRUE(set.contacts.empty()) << "the path ends outside";
  });
}

TEST_F(QueryAllocation, SceneIndexGrowsTheResultAndThenTakesNothing) {
  const SceneIndex index(scene(), {}, {});
  const std::vector<Ellipsoid> tools = path();
  on_every_target([&] {
    ContactSet set;
    for (const Ellipsoid& tool : tools) index.query(tool, set);
    const AllocationGuard guard;
    for (const Ellipsoid& tool : tools) index.query(tool, set);
    const std::size_t count = guard.count();
    EXPECT_EQ(count, 0U);
  });
}

TEST_F(QueryAllocation, ContactTrackerTakesNothingOnceTheResultHasRoom) {
  const SceneIndex index(scene(), {}, {});
  const std::vector<Ellipsoid> tools = path();
  on_every_target([&] {
    ContactTracker tracker(index);
    ContactSet set;
    set.contacts.reserve(3001);
    std::size_t most = 0;
    const AllocationGuard guard;
    for (const Ellipsoid& tool : tools) {
      for (int stay = 0; stay < 3; ++stay) tracker.query(tool, set);
      most = std::max(most, set.contacts.size());
    }
    const std::size_t count = guard.count();
    EXPECT_EQ(count, 0U);
    EXPECT_GT(most, 1024U);
  });
}

}  // namespace
}  // namespace palpate

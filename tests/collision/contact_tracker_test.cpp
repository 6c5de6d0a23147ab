// ContactTracker: whatever the tool does, the contacts are those of a fresh query.

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/contact_kernel.h>
#include <palpate/collision/contact_tracker.h>
#include <palpate/collision/splat_tracker.h>
#include <support/brute_force.h>
#include <support/effort.h>
#include <support/on_every_target.h>
#include <support/random_scenes.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::Bars;
using test::draws;
using test::scene_of;
using test::splat;
using test::Splat;

bool same_bits(const Contact& a, const Contact& b) {
  return a.k_min == b.k_min && a.lambda == b.lambda && a.point == b.point && a.normal == b.normal &&
         a.depth == b.depth;
}

/// A tool that walks.
struct Walker {
  Pose pose;
  Vector3d semi_axes{0.02, 0.02, 0.04};

  Ellipsoid tool() const { return Ellipsoid::from_semi_axes(pose, semi_axes); }
  /// By `length` in any direction, and as far on the surface of the tool by a turn.
  void step(test::Random& random, double length) {
    pose.position += length * random.direction();
    const Eigen::AngleAxisd turn(length / semi_axes.maxCoeff(), random.direction());
    pose.orientation = (Eigen::Quaterniond(turn) * pose.orientation).normalized();
  }
};

class ContactTrackerOnEveryTarget : public test::OnEveryTarget {
 protected:
  struct Seen {
    std::size_t contacts = 0;
    /// Of them, whose figures are not the same bits. Where rounding takes t the other way there is one, one
    /// in a hundred thousand; a tracker that lets its start be seen has nothing else.
    std::size_t different = 0;
    std::size_t searches = 0;  ///< at most: poses at which what is kept changed
  };

  /// Lets a tracker and fresh queries follow `path` and expects the same of both.
  static Seen follow(const SceneIndex& index, const std::vector<Ellipsoid>& path, const Bars& bars = {}) {
    ContactTracker tracker(index);
    ContactSet tracked, fresh;
    Seen seen;
    std::size_t kept = 0, walked = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
      SCOPED_TRACE(testing::Message() << "pose " << i);
      tracker.query(path[i], tracked);
      index.query(path[i], fresh);
      test::expect_close(tracked.contacts, fresh.contacts, path[i], bars);  // also in the same order
      EXPECT_LE(tracked.contacts.size(), tracked.filtered);
      EXPECT_LE(tracked.filtered, tracked.candidates);
      seen.contacts += tracked.contacts.size();
      for (std::size_t k = 0; k < std::min(tracked.contacts.size(), fresh.contacts.size()); ++k)
        seen.different += !same_bits(tracked.contacts[k], fresh.contacts[k]);
      seen.searches += i == 0 || tracked.filtered != kept || tracked.candidates != walked;
      kept = tracked.filtered;
      walked = tracked.candidates;
      if (HasFailure()) break;
    }
    EXPECT_LE(seen.different, seen.contacts / 1000);
    return seen;
  }
};

GaussianScene sphere_with_gaps_in_ids(std::uint64_t seed, std::size_t count = 20000) {
  test::Random random(seed);
  return test::with_gaps_in_ids(scene_of(sphere_of_splats(random, count)));
}

std::vector<Ellipsoid> random_walk(test::Random& random, Walker walker, std::size_t steps, double least,
                                   double most) {
  std::vector<Ellipsoid> path;
  for (std::size_t i = 0; i < steps; ++i) {
    path.push_back(walker.tool());
    walker.step(random, random.uniform(least, most));
    // Back to where it touches the sphere, whose splats are up to 5 cm large, so that the walk stays in
    // contact.
    walker.pose.position *= 1.0 + 0.1 * (1.005 - walker.pose.position.norm());
  }
  return path;
}

TEST_F(ContactTrackerOnEveryTarget, FollowsAHand) {
  test::Random random(301);
  const SceneIndex index(sphere_with_gaps_in_ids(300), {}, {});
  std::vector<std::vector<Ellipsoid>> paths;
  for (int i = 0; i < 5; ++i) {
    const Walker walker{{1.01 * random.direction(), random.rotation()}};
    paths.push_back(random_walk(random, walker, draws(1000), 1e-4, 1e-3));
  }
  on_every_target([&] {
    for (const std::vector<Ellipsoid>& path : paths) {
      const Seen seen = follow(index, path);
      EXPECT_GT(seen.contacts, path.size());
      EXPECT_LT(seen.searches, path.size() / 2) << "it looks anew at every pose";
    }
  });
}

TEST_F(ContactTrackerOnEveryTarget, KeepsWhatItFoundWhileTheToolStays) {
  const SceneIndex index(sphere_with_gaps_in_ids(302), {}, {});
  const Walker walker{{{0, 0, 1.01}, Eigen::Quaterniond::Identity()}};
  on_every_target([&] {
    const Seen seen = follow(index, std::vector<Ellipsoid>(20, walker.tool()));
    EXPECT_GT(seen.contacts, 20U);
    EXPECT_EQ(seen.searches, 1U);
  });
}

// Every length of step, from within the margin to far beyond it.
TEST_F(ContactTrackerOnEveryTarget, FollowsJumps) {
  test::Random random(303);
  const SceneIndex index(sphere_with_gaps_in_ids(304), {}, {});
  std::vector<Ellipsoid> path;
  Walker walker{{{0, 0, 1.0}, random.rotation()}};
  for (std::size_t i = 0; i < draws(2000); ++i) {
    walker.step(random, random.log_uniform(1e-6, 0.5));
    if (random.integer(0, 3) == 0) walker.pose.position.normalize();
    if (random.integer(0, 99) == 0) walker.pose.position *= 5.0;  // out of the scene
    path.push_back(walker.tool());
  }
  on_every_target([&] { EXPECT_GT(follow(index, path).contacts, 2 * path.size()); });
}

// A larger tool may touch what the search for the smaller one has dropped.
TEST_F(ContactTrackerOnEveryTarget, FollowsAToolThatGrowsAndShrinks) {
  test::Random random(305);
  const SceneIndex index(sphere_with_gaps_in_ids(306), {}, {});
  std::vector<Ellipsoid> path;
  Walker walker{{{0, 0, 1.005}, random.rotation()}};
  for (std::size_t i = 0; i < draws(1000); ++i) {
    const double phase = 0.05 * static_cast<double>(i);
    walker.semi_axes = Vector3d(0.02 + 0.01 * std::sin(phase), 0.02 + 0.015 * std::cos(1.7 * phase), 0.04);
    path.push_back(walker.tool());
  }
  on_every_target([&] { EXPECT_GT(follow(index, path).contacts, 5 * path.size()); });
}

// A long tool sweeps far with its ends when it turns in place, about every axis.
TEST_F(ContactTrackerOnEveryTarget, FollowsALongToolThatTurnsInPlace) {
  test::Random random(307);
  const SceneIndex index(sphere_with_gaps_in_ids(308), {}, {});
  std::vector<Ellipsoid> path;
  Walker walker{{{0, 0, 0.99}, random.rotation()}, {0.002, 0.01, 0.2}};
  for (std::size_t i = 0; i < draws(1000); ++i) {
    const Eigen::AngleAxisd turn{random.log_uniform(1e-5, 0.05), random.direction()};
    walker.pose.orientation = (Eigen::Quaterniond(turn) * walker.pose.orientation).normalized();
    path.push_back(walker.tool());
  }
  on_every_target([&] { EXPECT_GT(follow(index, path, {1e-11, 1e-6}).contacts, 2 * path.size()); });
}

TEST_F(ContactTrackerOnEveryTarget, FollowsInARegisteredScene) {
  test::Random random(309);
  const Similarity world{0.42, Eigen::Quaterniond(0.5, -0.7, 0.1, 0.3).normalized(), {3.25, -41.5, 1.125}};
  const SceneIndex index(sphere_with_gaps_in_ids(310), {}, world);
  const Walker walker{{Vector3d(0, 0, 1.01), random.rotation()}, {0.05, 0.05, 0.1}};
  std::vector<Ellipsoid> path = random_walk(random, walker, draws(1000), 1e-4, 1e-3);
  for (Ellipsoid& tool : path) {
    tool.center = world * tool.center;
    tool.axes = world.scale * (world.rotation.toRotationMatrix() * tool.axes);
  }
  on_every_target([&] { EXPECT_GT(follow(index, path, {1e-11, 1e-7}).contacts, 5 * path.size()); });
}

// Discs, needles and giants, whose minima are on plateaus: starting from the last minimum must not end
// elsewhere.
TEST_F(ContactTrackerOnEveryTarget, FollowsAmongWildSizes) {
  test::Random random(311);
  std::vector<Splat> splats;
  for (int i = 0; i < 300; ++i) splats.push_back(wild_splat(random, 1.0));
  const SceneIndex index(scene_of(splats), {}, {});
  const Walker walker{{{0, 0, 0}, random.rotation()}};
  std::vector<Ellipsoid> path;
  Walker w = walker;
  for (std::size_t i = 0; i < draws(3000); ++i) {
    w.step(random, random.uniform(1e-4, 2e-3));
    path.push_back(w.tool());
  }
  on_every_target([&] { EXPECT_GT(follow(index, path, {1e-9, 0.0}).contacts, 5 * path.size()); });
}

// A place with more Gaussians than are kept, and the way there and back.
TEST_F(ContactTrackerOnEveryTarget, FallsBackWhereItIsCrowded) {
  test::Random random(312);
  std::vector<Splat> splats;
  for (std::size_t i = 0; i < 2 * CandidateSet::kCapacity; ++i) {
    const Vector3d at = random.in_box(0.05), semi_axes = random.semi_axes(1e-3, 0.02);
    splats.push_back(splat(at, semi_axes, random.rotation()));
  }
  const SceneIndex index(scene_of(splats), {}, {});
  std::vector<Ellipsoid> path;
  for (int i = -100; i <= 100; ++i)
    path.push_back(Ellipsoid::from_semi_axes({{2e-3 * i, 0, 0}, random.rotation()}, {0.04, 0.05, 0.06}));
  std::size_t most = 0;
  ContactSet set;
  for (const Ellipsoid& tool : path) {
    index.query(tool, set);
    most = std::max(most, set.contacts.size());
  }
  EXPECT_GT(most, CandidateSet::kCapacity);
  on_every_target([&] { EXPECT_GT(follow(index, path).contacts, 10000U); });
}

// A bound on the pairs cuts the answer off and nothing else: what there is comes in the same order.
TEST_F(ContactTrackerOnEveryTarget, OfSoManyPairsFindsThoseThatComeFirst) {
  constexpr std::size_t kBuffer = 192;  // by as many it may be exceeded
  test::Random random(19);
  const SceneIndex index(scene_of(test::sphere_of_splats(random, 20000)), {}, {});
  const Ellipsoid tool{{0.9, 0, 0}, 0.5 * Eigen::Matrix3d::Identity()};
  on_every_target([&] {
    ContactSet all, some;
    index.query(tool, all);
    ASSERT_TRUE(all.complete);
    ASSERT_GT(all.contacts.size(), 500U);
    for (const std::size_t most :
         {std::size_t{0}, std::size_t{100}, all.filtered / 2, all.filtered + 1, kAllPairs}) {
      for (const bool tracks : {false, true}) {
        ContactTracker tracker(index);
        tracks ? tracker.query(tool, some, {.pairs = most})
               : index.query(tool, Precision::kDouble, some, {.pairs = most});
        if (!tracks) {  // which looks at a few pairs more
          EXPECT_EQ(some.complete, most > all.filtered) << most;
        }
        EXPECT_TRUE(!some.complete || some.contacts.size() == all.contacts.size()) << most;
        EXPECT_LE(some.contacts.size(), std::max(most, most + kBuffer));  // which may be too large for it
        EXPECT_GE(some.contacts.size(), most > kBuffer ? 1U : 0U);
        ASSERT_LE(some.contacts.size(), all.contacts.size());
        for (std::size_t k = 0; k < some.contacts.size(); ++k)
          EXPECT_EQ(some.contacts[k].id, all.contacts[k].id) << most;
      }
    }
  });
}

// Whether anything is touched at all, also where more is near than is kept.
TEST_F(ContactTrackerOnEveryTarget, OfOneContactFindsOneWhereThereIsAny) {
  constexpr QueryLimit kAny{.contacts = 1};
  test::Random random(23);
  const SceneIndex index(scene_of(test::sphere_of_splats(random, 20000)), {}, {});
  on_every_target([&] {
    int touching = 0, apart = 0;
    for (const double radius : {0.01, 0.1, 0.5}) {
      ContactTracker tracker(index);
      for (int k = 0; k < 60; ++k) {
        const Vector3d at = random.vector(1.0 - 1.5 * radius, 1.0 + 1.5 * radius);
        const Ellipsoid tool{at, radius * Eigen::Matrix3d::Identity()};
        ContactSet all, tracked, fresh;
        index.query(tool, all);
        index.query(tool, Precision::kSingle, fresh, kAny);
        tracker.query(tool, tracked, kAny);
        EXPECT_EQ(fresh.contacts.empty(), all.contacts.empty());
        EXPECT_EQ(tracked.contacts.empty(), all.contacts.empty());
        EXPECT_TRUE(fresh.complete || !fresh.contacts.empty());
        EXPECT_LE(fresh.contacts.size(), 192U);
        (all.contacts.empty() ? apart : touching) += 1;
      }
    }
    EXPECT_GT(touching, 40);
    EXPECT_GT(apart, 20);
  });
}

// A search of a tool that moves by 4 % of its radius in a tick lasts for ticks where few Gaussians are kept.
// Where many are, all of them would cost more in every tick than a search does.
TEST_F(ContactTrackerOnEveryTarget, SearchesSeldomForAFastToolAmongFew) {
  constexpr double kRadius = 0.01, kStep = 0.04 * kRadius;
  constexpr int kTicks = 50;
  const auto searches_on_plane = [&](double spacing) {
    std::vector<Splat> splats;
    const int half = static_cast<int>(0.03 / spacing);
    for (int i = -half; i <= half; ++i)
      for (int k = -half; k <= half; ++k)
        splats.push_back(splat({i * spacing, k * spacing, 0.0}, {spacing, spacing, 1e-4},
                               Eigen::Quaterniond::Identity(), 0.95));
    const SceneIndex index(scene_of(splats), {}, {});
    ContactTracker tracker(index);
    ContactSet set;
    int searches = 0;
    for (int tick = 0; tick < kTicks; ++tick) {
      const double x = kStep * (tick - kTicks / 2);
      const Vector3d center(x, 0.0, 0.5 * kRadius);
      tracker.query({center, kRadius * Eigen::Matrix3d::Identity()}, set);
      EXPECT_FALSE(set.contacts.empty());
      searches += tracker.searched() > 0;
    }
    return searches;
  };
  on_every_target([&] {
    EXPECT_LE(searches_on_plane(0.006), kTicks * 2 / 3);
    EXPECT_GT(searches_on_plane(0.0005), kTicks - 5);  // the first one has no last step, and lasts
  });
}

TEST_F(ContactTrackerOnEveryTarget, SearchesNoCrowdTwice) {
  test::Random random(24);
  const SceneIndex index(scene_of(test::sphere_of_splats(random, 20000)), {}, {});
  const auto tool_at = [](double x) { return Ellipsoid{{x, 0, 0}, 0.9 * Eigen::Matrix3d::Identity()}; };
  on_every_target([&] {
    ContactTracker tracker(index);
    ContactSet all, set;
    tracker.query(tool_at(0.5), set);
    ASSERT_GT(set.contacts.size(), CandidateCache::kCapacity);
    EXPECT_GT(tracker.searched(), CandidateCache::kCapacity);
    for (const double x : {0.5, 0.501, 0.499, 0.6}) {
      tracker.query(tool_at(x), set);
      index.query(tool_at(x), all);
      EXPECT_EQ(set.contacts.size(), all.contacts.size());
      EXPECT_EQ(tracker.searched() > 0, x == 0.6) << x;
    }
    tracker.query(Ellipsoid{{0.95, 0, 0}, 0.1 * Eigen::Matrix3d::Identity()}, set);
    EXPECT_GT(set.contacts.size(), 20U);
    EXPECT_LT(set.candidates, 4000U);
  });
}

TEST_F(ContactTrackerOnEveryTarget, OfNothingFindsNothing) {
  const SceneIndex index(GaussianScene{}, {}, {});
  on_every_target([&] {
    ContactTracker tracker(index);
    ContactSet set;
    set.contacts.emplace_back();
    for (int i = 0; i < 3; ++i) {
      tracker.query({{0.01 * i, 0, 0}, Eigen::Matrix3d::Identity()}, set);
      EXPECT_TRUE(set.contacts.empty());
      EXPECT_EQ(set.candidates + set.filtered, 0U);
    }
  });
}

// What splatting draws reaches three times as far as an ellipsoid: the oracle is a scene of ellipsoids that
// large.
TEST(SplatTracker, FindsAllThatIsDrawnInASolid) {
  test::Random r(11);
  std::vector<test::Splat> splats = test::sphere_of_splats(r, 3000);
  for (int i = 0; i < 300; ++i) splats.push_back(test::wild_splat(r, 1.0));
  const Similarity world_from_scene{0.3, r.rotation(), {0.1, -0.2, 0.3}, false};
  SceneFilter threefold;
  threefold.sigma = CandidateCache::kDrawn;
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, world_from_scene),
      oracle(test::scene_of(splats), threefold, world_from_scene);
  std::size_t found = 0;
  for (const Ellipsoid& captured : test::tools_at_sphere(r, 200)) {
    const Ellipsoid solid{world_from_scene * captured.center, captured.axes};
    SplatTracker tracker(index);
    const LocalSplats& near = tracker.around(solid);
    ContactSet drawn;
    oracle.query(solid, drawn);
    std::vector<std::uint32_t> kept(near.id.begin(),
                                    near.id.begin() + static_cast<std::ptrdiff_t>(near.size));
    std::sort(kept.begin(), kept.end());
    for (const Contact& contact : drawn.contacts)
      ASSERT_TRUE(std::binary_search(kept.begin(), kept.end(), contact.id)) << contact.id;
    found += drawn.contacts.size();
    for (std::size_t i = 0; i < near.size; ++i) {
      const double sigma = 0.3 * splats[near.id[i]].sigma.maxCoeff();
      ASSERT_NEAR(near.radius[i], sigma, 1e-5 * sigma) << "the size itself is not enlarged";
    }
  }
  EXPECT_GT(found, 5000U);
}

}  // namespace
}  // namespace palpate

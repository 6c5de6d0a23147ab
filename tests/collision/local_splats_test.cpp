// Gaussians as splatting draws them, against their own parameters.

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <palpate/collision/candidate_cache.h>
#include <palpate/collision/local_splats.h>
#include <palpate/collision/scene_index.h>
#include <palpate/collision/splat_tracker.h>
#include <support/on_every_target.h>
#include <support/random_pairs.h>
#include <support/splats.h>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::Splat;

/// With `flat` axes of no length.
Splat any_splat(test::Random& random, std::size_t flat) {
  const Vector3d at = random.in_box(0.1), semi_axes = random.semi_axes(1e-3, 1e-1);
  const Eigen::Quaterniond q = random.rotation();
  Splat splat = test::splat(at, semi_axes, q, random.uniform(0.2, 0.95));
  const int first = random.integer(0, 2);
  for (std::size_t k = 0; k < flat; ++k) splat.sigma[(first + static_cast<int>(k)) % 3] = 0.0;
  return splat;
}

class LocalSplatsOnEveryTarget : public test::OnEveryTarget {};

TEST_F(LocalSplatsOnEveryTarget, WhitenTheGaussians) {
  test::Random random(911);
  std::vector<Splat> splats;
  for (std::size_t i = 0; i < 303; ++i) splats.push_back(any_splat(random, i % 3));
  const Similarity world{0.3, random.rotation(), {5.0, -3.0, 2.0}};
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, world);
  const Vector3d middle = world * Vector3d(0, 0, 0);
  on_every_target([&] {
    CandidateCache near;
    near.search_drawn(index, Ellipsoid{middle, Matrix3d::Identity()});
    LocalSplats local;
    near.splats(index, local);
    ASSERT_EQ(local.size, splats.size());
    for (std::size_t i = 0; i < local.size; ++i) {
      const Splat& splat = splats[local.id[i]];
      const Vector3d sigma = world.scale * splat.sigma;
      EXPECT_LE((local.position(i) - world * splat.position).norm(), 1e-7);
      EXPECT_NEAR(local.radius[i], sigma.maxCoeff(), 1e-5 * sigma.maxCoeff());
      EXPECT_NEAR(local.opacity[i], splat.opacity, 1e-6);
      Matrix3d L;
      for (Eigen::Index k = 0; k < 9; ++k) L(k / 3, k % 3) = local.whitening[static_cast<std::size_t>(k)][i];
      const auto& q = splat.rotation;
      const Matrix3d turned =
          (world.rotation * Eigen::Quaterniond(q[0], q[1], q[2], q[3])).toRotationMatrix();
      const Vector3d thick = sigma.cwiseMax(1e-3 * sigma.maxCoeff());
      // L (R diag(sigma)) is a rotation.
      const Matrix3d unit = L * turned * thick.asDiagonal();
      EXPECT_LE((unit.transpose() * unit - Matrix3d::Identity()).cwiseAbs().maxCoeff(), 2e-3)
          << splat.sigma.transpose();
    }
  });
}

constexpr double kLarge = 0.05;

/// A square of 1 m of small discs side by side, and some large ones, of which there are many more than fit.
std::vector<Splat> crowded_square(test::Random& random) {
  constexpr int kSide = 250;
  std::vector<Splat> splats;
  for (int i = 0; i < kSide * kSide; ++i) {
    const int column = i % kSide, row = i / kSide;
    const Vector3d at{(column + random.uniform(0, 1)) / kSide, (row + random.uniform(0, 1)) / kSide, 0.0};
    const double sigma = i % 1000 == 0 ? kLarge : random.log_uniform(1e-3, 3e-3);
    splats.push_back(test::splat(at, {sigma, sigma, 1e-4}));
  }
  return splats;
}

LocalSplats around_square(const SceneIndex& index, double radius) {
  CandidateCache near;
  near.search_drawn(index, {Vector3d(0.5, 0.5, 0.0), radius * Matrix3d::Identity()});
  LocalSplats local;
  near.splats(index, local);
  return local;
}

TEST_F(LocalSplatsOnEveryTarget, HideAsMuchWhereASampleStandsForThem) {
  constexpr int kCells = 8;
  using Cells = Eigen::Array<double, kCells, kCells>;
  test::Random random(912);
  const std::vector<Splat> splats = crowded_square(random);
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  const auto add = [](Cells& cells, const Vector3d& at, double sigma) {
    const auto cell = [](double x) { return std::clamp(static_cast<int>(kCells * x), 0, kCells - 1); };
    cells(cell(at.x()), cell(at.y())) += sigma * sigma;
  };
  Cells all = Cells::Zero();
  std::size_t large = 0;
  for (const Splat& splat : splats) {
    if (splat.sigma.x() == kLarge) {
      ++large;
    } else {
      add(all, splat.position, splat.sigma.x());
    }
  }
  on_every_target([&] {
    const LocalSplats local = around_square(index, 2.0);
    EXPECT_LE(local.size, LocalSplats::kCapacity);
    EXPECT_GE(local.size, LocalSplats::kCapacity / 3);
    Cells drawn = Cells::Zero();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < local.size; ++i) {
      if (splats[local.id[i]].sigma.x() == kLarge) {
        ++kept;
      } else {
        add(drawn, local.position(i), local.radius[i]);
      }
    }
    // None of the large ones is left out, all hides as much as it did, and every part of the square does,
    // more evenly than if 45 in each were drawn by lot.
    EXPECT_EQ(kept, large);
    EXPECT_NEAR(drawn.sum() / all.sum(), 1.0, 0.02);
    EXPECT_LT(std::sqrt((drawn / all - 1.0).square().mean()), 0.8 / std::sqrt(45.0)) << drawn / all;
  });
}

TEST(LocalSplats, OfALargerSolidAreAmongThoseOfASmallerOne) {
  test::Random random(913);
  const SceneIndex index(test::scene_of(crowded_square(random)), SceneFilter{}, Similarity{});
  const LocalSplats fewer = around_square(index, 2.0), more = around_square(index, 0.3);
  const std::set<std::uint32_t> known(more.id.begin(),
                                      more.id.begin() + static_cast<std::ptrdiff_t>(more.size));
  std::size_t inside = 0;
  for (std::size_t i = 0; i < fewer.size; ++i) {
    if ((fewer.position(i) - Vector3d(0.5, 0.5, 0.0)).norm() > 0.29) continue;
    ++inside;
    EXPECT_TRUE(known.contains(fewer.id[i]));
  }
  EXPECT_GT(inside, 300U);
  EXPECT_GT(more.size, 3 * inside);
}

std::vector<std::uint32_t> ids_of(const LocalSplats& splats) {
  return {splats.id.begin(), splats.id.begin() + static_cast<std::ptrdiff_t>(splats.size)};
}

Ellipsoid ball_at(double x, double radius) { return {{x, 0.5, 0.0}, radius * Matrix3d::Identity()}; }

/// Splats on the unit square, few enough to be kept all.
std::vector<Splat> loose_square(test::Random& random) {
  std::vector<Splat> splats;
  for (int i = 0; i < 3000; ++i)
    splats.push_back(test::splat({random.uniform(0, 1), random.uniform(0, 1), 0.0}, {2e-3, 2e-3, 2e-4}));
  return splats;
}

TEST_F(LocalSplatsOnEveryTarget, InPortionsAreTheSame) {
  constexpr std::size_t kMost = 200, kAFewBesides = 48 * 16;
  test::Random random(914);
  const SceneIndex index(test::scene_of(loose_square(random)), SceneFilter{}, Similarity{});
  on_every_target([&] {
    SplatTracker whole(index), divided(index);
    for (const Ellipsoid& solid : {ball_at(0.5, 0.4), ball_at(0.1, 0.3), ball_at(0.5, 2.0)}) {
      const std::vector<std::uint32_t> before = ids_of(divided.newest());
      int calls = 1;
      for (; !divided.update(solid, kMost); ++calls) {
        EXPECT_TRUE(divided.has_searched());
        ASSERT_EQ(ids_of(divided.newest()), before) << "what was found last stays meanwhile";
        ASSERT_GT(divided.walked(), 0U);
        ASSERT_LT(divided.walked(), kMost + kAFewBesides);
        EXPECT_EQ(divided.taken_up(), 0U);
      }
      EXPECT_GE(calls, 2);
      EXPECT_EQ(ids_of(divided.newest()), ids_of(whole.around(solid)));
      EXPECT_EQ(divided.taken_up(), divided.newest().size);
      EXPECT_TRUE(divided.has_searched());
      EXPECT_TRUE(divided.update(solid, 0)) << "it knows";
      EXPECT_FALSE(divided.has_searched());
      EXPECT_EQ(divided.taken_up(), 0U);
    }
  });
}

TEST(LocalSplats, ASearchThatIsUnderWayIsOfOneSolidInOneIndex) {
  test::Random random(915);
  SceneIndex index(test::scene_of(loose_square(random)), SceneFilter{}, Similarity{});
  SplatTracker tracker(index);
  const Ellipsoid a = ball_at(0.3, 0.3), b = ball_at(0.7, 0.3);
  ASSERT_FALSE(tracker.update(a, 200));
  const std::vector<std::uint32_t> of_b = ids_of(tracker.around(b));
  EXPECT_EQ(of_b, ids_of(SplatTracker(index).around(b)));
  ASSERT_FALSE(tracker.update(a, 200));
  EXPECT_EQ(ids_of(tracker.newest()), of_b);
  index = SceneIndex(test::scene_of(loose_square(random)), SceneFilter{}, Similarity{});
  EXPECT_EQ(ids_of(tracker.around(a)), ids_of(SplatTracker(index).around(a)));
}

// In portions as well: what stands for the rest fits, and hides as much.
TEST(LocalSplats, OfACrowdAreASampleThatFitsWhereverItIsDivided) {
  test::Random random(916);
  const std::vector<Splat> splats = crowded_square(random);
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  const auto hidden = [](const LocalSplats& near) {
    double sum = 0.0;
    for (std::size_t i = 0; i < near.size; ++i)
      if (near.radius[i] < kLarge) sum += static_cast<double>(near.radius[i] * near.radius[i]);
    return sum;
  };
  SplatTracker whole(index);
  const double all = hidden(whole.around(ball_at(0.5, 2.0)));
  for (const std::size_t most : {500U, 3000U, 20'000U}) {
    SplatTracker divided(index);
    while (!divided.update(ball_at(0.5, 2.0), most)) {
    }
    EXPECT_GT(divided.newest().size, LocalSplats::kCapacity / 3) << most;
    EXPECT_NEAR(hidden(divided.newest()) / all, 1.0, 0.05) << most;
  }
}

// The grain of the last search is where the next begins; it does not outlast the crowd.
TEST(LocalSplats, ForgetTheirGrainWhereThereIsRoom) {
  test::Random random(917);
  const SceneIndex index(test::scene_of(crowded_square(random)), SceneFilter{}, Similarity{});
  SplatTracker tracker(index);
  std::size_t at_first = 0;
  for (const double x : {0.3, 0.32, 0.34}) {
    const std::size_t size = tracker.around(ball_at(x, 0.3)).size;
    if (at_first == 0) at_first = tracker.walked();
    EXPECT_LT(tracker.walked(), 1.5 * at_first) << "searched once: the grain of before does";
    EXPECT_GT(size, LocalSplats::kCapacity / 3) << x;
    EXPECT_LE(size, LocalSplats::kCapacity) << x;
  }
  const Ellipsoid elsewhere = ball_at(0.85, 0.02);
  EXPECT_EQ(ids_of(tracker.around(elsewhere)), ids_of(SplatTracker(index).around(elsewhere)));
}

}  // namespace
}  // namespace palpate

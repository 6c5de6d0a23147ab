// Gaussians as splatting draws them, against their own parameters.

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <palpate/collision/local_splats.h>
#include <palpate/collision/neighbourhood.h>
#include <palpate/collision/scene_index.h>
#include <support/on_every_target.h>
#include <support/random_pairs.h>
#include <support/splats.h>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::Random;
using test::Splat;

/// With `flat` axes of no length.
Splat any_splat(Random& random, std::size_t flat) {
  Splat splat = test::splat(random.in_box(0.1), random.semi_axes(1e-3, 1e-1), random.rotation(),
                            random.uniform(0.2, 0.95));
  const int first = random.integer(0, 2);
  for (std::size_t k = 0; k < flat; ++k) splat.sigma[(first + static_cast<int>(k)) % 3] = 0.0;
  return splat;
}

class LocalSplatsOnEveryTarget : public test::OnEveryTarget {};

TEST_F(LocalSplatsOnEveryTarget, WhitenTheGaussians) {
  Random random(911);
  std::vector<Splat> splats;
  for (std::size_t i = 0; i < 303; ++i) splats.push_back(any_splat(random, i % 3));
  const Similarity world{0.3, random.rotation(), {5.0, -3.0, 2.0}};
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, world);
  const Vector3d middle = world * Vector3d(0, 0, 0);
  on_every_target([&] {
    Neighbourhood near;
    ASSERT_TRUE(near.search_drawn(index, Ellipsoid{middle, Matrix3d::Identity()}));
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

}  // namespace
}  // namespace palpate

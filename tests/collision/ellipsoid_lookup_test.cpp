#include <palpate/collision/ellipsoid_lookup.h>

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include <support/random_scenes.h>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::scene_of;
using test::with_gaps_in_ids;

/// That `lookup` has what the filter keeps of `scene`.
void expect_same(const GaussianScene& scene, const SceneFilter& filter, const Similarity& world,
                 double size) {
  const SceneIndex index(scene, filter, world);
  const EllipsoidLookup lookup(index);
  FilterReport report;
  const EllipsoidScene wanted = filter_scene(scene, filter, world, report);
  const EllipsoidScene all = lookup.all();
  ASSERT_EQ(all.size(), wanted.size());
  ASSERT_EQ(all.id, wanted.id);
  EXPECT_TRUE(std::is_sorted(all.id.begin(), all.id.end()));
  ASSERT_EQ(all.opacity.size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    for (const Ellipsoid& found : {all.ellipsoids[i], lookup.at(wanted.id[i])}) {
      const Ellipsoid& truth = wanted.ellipsoids[i];
      EXPECT_LE((found.center - truth.center).norm(), 1e-6 * size) << wanted.id[i];
      // A quaternion in floats turns by some 1e-7.
      EXPECT_LE((found.axes * found.axes.transpose() - truth.axes * truth.axes.transpose()).norm(),
                1e-6 * truth.axes.squaredNorm())
          << wanted.id[i];
    }
    EXPECT_NEAR(all.opacity[i], wanted.opacity[i], 1e-12);
  }
}

Similarity registration(test::Random& random) {
  return {random.log_uniform(0.1, 10.0), random.rotation(), random.in_box(5.0)};
}

TEST(EllipsoidLookup, HasWhatTheFilterKeepsOfARegisteredScene) {
  test::Random random(21);
  std::vector<test::Splat> splats = test::sphere_of_splats(random, 3000);
  for (std::size_t k = 0; k < splats.size(); k += 3) splats[k].opacity = random.uniform(0.01, 0.5);
  SceneFilter filter;
  filter.opacity_min = 0.2;
  filter.sigma = 1.7;
  const Similarity world = registration(random);
  expect_same(with_gaps_in_ids(scene_of(splats)), filter, world,
              2.0 * world.scale + world.translation.norm());
}

TEST(EllipsoidLookup, HasWhatTheFilterKeepsWhereItIsVisible) {
  test::Random random(22);
  SceneFilter filter;
  filter.iso = 0.05;
  expect_same(scene_of(test::sphere_of_splats(random, 500)), filter, {}, 1.0);
}

TEST(EllipsoidLookup, HasWildOnesDiscsAndNeedles) {
  test::Random random(23);
  std::vector<test::Splat> splats;
  for (int k = 0; k < 500; ++k) splats.push_back(test::wild_splat(random, 100.0));
  for (int k = 0; k < 3; ++k) {
    const Vector3d at = random.in_box(100.0);
    splats.push_back(test::splat(at, {0.1, 0.0, 0.0}, random.rotation()));
  }
  expect_same(with_gaps_in_ids(scene_of(splats)), {}, registration(random), 2000.0);
}

// Blocks have more lanes than there are Gaussians.
TEST(EllipsoidLookup, HasOneToFortyAndNone) {
  test::Random random(24);
  for (std::size_t count = 0; count <= 40; ++count)
    expect_same(scene_of(test::sphere_of_splats(random, count)), {}, {}, 1.0);
}

TEST(EllipsoidLookup, FollowsTheRegistrationOfItsIndex) {
  test::Random random(25);
  const GaussianScene scene = scene_of(test::sphere_of_splats(random, 50));
  const Similarity world = registration(random);
  const SceneIndex fresh(scene, {}, world), captured(scene, {}, {});
  const SceneIndex moved = captured.registered(world);
  const EllipsoidLookup a(fresh), b(moved);
  for (std::uint32_t id = 0; id < 50; ++id) {
    EXPECT_TRUE(a.at(id).center.isApprox(b.at(id).center, 1e-12)) << id;
    EXPECT_TRUE(a.at(id).axes.isApprox(b.at(id).axes, 1e-12)) << id;
  }
}

TEST(EllipsoidLookup, IsWhereTheContactsAre) {
  test::Random random(26);
  const GaussianScene scene = with_gaps_in_ids(scene_of(test::sphere_of_splats(random, 2000)));
  const SceneIndex index(scene, {}, registration(random));
  const EllipsoidLookup lookup(index);
  const Ellipsoid any = lookup.at(5);
  ContactSet found;
  index.query(Ellipsoid::from_semi_axes(Pose{any.center}, Vector3d::Constant(0.3 * index.frame().scale)),
              found);
  ASSERT_GE(found.contacts.size(), 10U);
  for (const Contact& c : found.contacts)
    EXPECT_LE((lookup.at(c.id).center - c.center).norm(), 1e-9 * index.frame().size);
}

}  // namespace
}  // namespace palpate

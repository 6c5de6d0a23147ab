// SceneIndex against a loop over all Gaussians in scalar double precision, on every instruction set. The bars
// are those of two codes that round differently; simd_oracle_test.cpp compares with extended precision.

#include <cmath>
#include <cstdio>
#include <limits>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/scene_index.h>
#include <support/brute_force.h>
#include <support/effort.h>
#include <support/on_every_target.h>
#include <support/random_scenes.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::Bars;
using test::BruteForce;
using test::draws;
using test::in_bytes;
using test::in_logarithms;
using test::random_tools;
using test::scene_of;
using test::splat;
using test::Splat;
using test::with_gaps_in_ids;

/// Size ratios to 1e8: K is as good as its own conditioning, and so flat that where it is least means little.
constexpr Bars kWild{1e-9, 0.0};

class SceneIndexOnEveryTarget : public test::OnEveryTarget {
 protected:
  static void TearDownTestSuite() {
    const test::WorstSeen worst = test::worst_seen();
    std::printf("  against brute force: worst |dK_min| %.1e, worst of lambda, normal, point and depth %.1e\n",
                worst.k, worst.place);
  }

  /// Compares the index of `scene` with brute force for all `tools`; there must be more than `least`
  /// contacts.
  static void check(const GaussianScene& scene, std::vector<Ellipsoid> tools, std::size_t least,
                    const Bars& bars = {}, const SceneFilter& filter = {}, const Similarity& world = {}) {
    const SceneIndex index(scene, filter, world);
    const BruteForce truth(scene, filter, world, std::move(tools));
    ASSERT_EQ(index.size(), truth.scene().size());
    on_every_target([&] { EXPECT_GT(truth.check(index, bars), least / test::kSlowdown); });
  }
};

std::vector<Splat> wild_splats(test::Random& random, std::size_t count, double half) {
  std::vector<Splat> splats;
  for (std::size_t i = 0; i < count; ++i) splats.push_back(wild_splat(random, half));
  return splats;
}

TEST_F(SceneIndexOnEveryTarget, OfWildSizes_vs_bruteforce) {
  test::Random random(71);
  const GaussianScene scene = with_gaps_in_ids(scene_of(wild_splats(random, 3000, 100.0)));
  check(scene, random_tools(random, draws(2000), 150.0, 1e-4, 50.0), 5000, kWild);
}

TEST_F(SceneIndexOnEveryTarget, OfTwentyThousandSplats_vs_bruteforce) {
  test::Random random(72);
  const GaussianScene scene = with_gaps_in_ids(scene_of(sphere_of_splats(random, 20000)));
  check(scene, tools_at_sphere(random, draws(1000)), 5000);
}

TEST_F(SceneIndexOnEveryTarget, OfManyDuplicates_vs_bruteforce) {
  test::Random random(73);
  std::vector<Splat> splats;
  for (int i = 0; i < 40; ++i) splats.insert(splats.end(), 25, wild_splat(random, 2.0));
  check(scene_of(splats), random_tools(random, draws(100), 3.0, 1e-2, 1.0), 1000, kWild);
}

TEST_F(SceneIndexOnEveryTarget, OfOneCentre_vs_bruteforce) {
  test::Random random(74);
  std::vector<Splat> splats;
  for (int i = 0; i < 500; ++i) {
    const Vector3d semi_axes = wild_semi_axes(random);
    splats.push_back(splat({1, 2, 3}, semi_axes, random.rotation()));
  }
  check(scene_of(splats), random_tools(random, draws(100), 5.0, 1e-3, 1.0), 500, kWild);
}

// Where the centres coincide, K is 1 everywhere and the way out is across the thinnest extent.
TEST_F(SceneIndexOnEveryTarget, WithItsCentreInTheTools_vs_bruteforce) {
  test::Random random(75);
  std::vector<Splat> splats;
  for (int i = 0; i < 40; ++i) {
    const Vector3d semi_axes = random.semi_axes(0.01, 1.0);
    splats.push_back(splat({1, 2, 3}, semi_axes, random.rotation()));
  }
  splats.push_back(splat({1, 2, 3}, {0.1, 0.2, 0.0}, random.rotation()));
  splats.push_back(splat({1, 2, 3}, {0.0, 0.2, 0.0}, random.rotation()));
  const GaussianScene scene = scene_of(splats);
  check(scene, {Ellipsoid::from_semi_axes({{1, 2, 3}, random.rotation()}, {0.1, 0.2, 0.3})}, 41);
  SceneIndex index(scene, {}, {});
  ContactSet set;
  index.query({{1, 2, 3}, Vector3d(0.1, 0.2, 0.3).asDiagonal()}, set);
  ASSERT_EQ(set.contacts.size(), splats.size());
  for (const Contact& c : set.contacts) {
    EXPECT_EQ(c.k_min, 1.0);
    EXPECT_EQ(c.lambda, 0.5);
  }
}

TEST_F(SceneIndexOnEveryTarget, OfCentresOnALine_vs_bruteforce) {
  test::Random random(76);
  std::vector<Splat> splats;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d at{random.uniform(-5, 5), 0, 0}, semi_axes = random.semi_axes(1e-3, 0.1);
    splats.push_back(splat(at, semi_axes, random.rotation()));
  }
  // And centres at 2^-k, so that no plane halves what is left.
  for (int k = 0; k < 1000; ++k)
    splats.push_back(splat({std::ldexp(1.0, -k), 0, 0}, Vector3d::Constant(1e-3)));
  std::vector<Ellipsoid> tools = random_tools(random, draws(50), 0.1, 1e-2, 0.5);
  tools.push_back({{3.0, 0.0, 0.0}, 0.1 * Eigen::Matrix3d::Identity()});
  check(scene_of(splats), tools, 1000);
}

// One kilometre: a float is 0.06 mm there, which the scene has lost but the query must not lose again.
TEST_F(SceneIndexOnEveryTarget, AKilometreAway_vs_bruteforce) {
  test::Random random(77);
  const Vector3d far(600.0, -800.0, 30.0);
  std::vector<Splat> splats = sphere_of_splats(random, 20000);
  for (Splat& s : splats) s.position += far;
  std::vector<Ellipsoid> tools = tools_at_sphere(random, draws(500));
  for (Ellipsoid& tool : tools) tool.center += far;
  check(scene_of(splats), tools, 500, {1e-11, 1e-7});
}

// A georeferenced scene, whose origin takes the large part of its coordinates. In the world a double is 1e-9
// m there, a tool of 2 cm hence no better placed than 1e-7 of its radius.
TEST_F(SceneIndexOnEveryTarget, AtAFarOrigin_vs_bruteforce) {
  test::Random random(78);
  const Vector3d far(4.5e6, 5.4e6, 3e2);
  GaussianScene scene = scene_of(sphere_of_splats(random, 20000));
  scene.origin = far;
  std::vector<Ellipsoid> tools = tools_at_sphere(random, draws(500));
  for (Ellipsoid& tool : tools) tool.center += far;
  check(scene, tools, 500, {3e-7, 0.0, far.norm()});
  // And brought back by the registration.
  Similarity world;
  world.translation = -far;
  check(scene, tools_at_sphere(random, draws(500)), 500, {3e-7, 0.0, far.norm()}, {}, world);
}

// Without an origin: positions are multiples of 6 cm, of the tool's 2 cm nothing may be lost.
TEST_F(SceneIndexOnEveryTarget, AThousandKilometresAwayInFloats_vs_bruteforce) {
  test::Random random(79);
  const Vector3d far(1e6, -1e6, 1e6);
  std::vector<Splat> splats = sphere_of_splats(random, 20000);
  for (Splat& s : splats) s.position += far;
  std::vector<Ellipsoid> tools = tools_at_sphere(random, draws(500));
  for (Ellipsoid& tool : tools) tool.center += far;
  check(scene_of(splats), tools, 500, {1e-7, 0.0});
}

TEST_F(SceneIndexOnEveryTarget, OfOneToFortyGaussians_vs_bruteforce) {
  test::Random random(80);
  for (std::size_t n = 1; n <= 40; ++n) {
    std::vector<Splat> splats = wild_splats(random, n, 1.0);
    splats[n / 2] = splat({0, 0, 0}, {0.5, 0.2, 0.0});
    std::vector<Ellipsoid> tools = random_tools(random, 50, 1.5, 0.1, 1.0);
    tools.push_back(Ellipsoid::from_semi_axes({}, {0.1, 0.1, 0.1}));  // touches that one, whatever is drawn
    check(scene_of(splats), tools, 0, kWild);
    if (HasFailure()) break;
  }
}

// More than one buffer of pairs takes several rounds, each ordered by id; all of them are one list.
TEST_F(SceneIndexOnEveryTarget, WithThousandsOfContacts_vs_bruteforce) {
  test::Random random(81);
  for (const std::size_t count : {255U, 256U, 257U, 1000U, 5000U}) {
    std::vector<Splat> splats;
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3d at = random.in_box(0.3), semi_axes = random.semi_axes(1e-3, 0.2);
      splats.push_back(splat(at, semi_axes, random.rotation()));
    }
    const Pose pose{{0, 0, 0}, random.rotation()};
    const auto ball = [&](double r) { return Ellipsoid::from_semi_axes(pose, {r, 0.9 * r, 0.8 * r}); };
    check(with_gaps_in_ids(scene_of(splats)), {ball(1.0)}, count - 1);  // all of it
    check(with_gaps_in_ids(scene_of(splats)), {ball(0.2)}, count / 10);
  }
}

TEST_F(SceneIndexOnEveryTarget, RegisteredByASimilarity_vs_bruteforce) {
  test::Random random(82);
  const GaussianScene scene = scene_of(sphere_of_splats(random, 20000));
  Similarity world{0.42, Eigen::Quaterniond(0.5, -0.7, 0.1, 0.3).normalized(), {3.25, -41.5, 1.125}};
  for (const bool mirrored : {false, true}) {
    world.mirrored = mirrored;
    std::vector<Ellipsoid> tools = tools_at_sphere(random, draws(500));
    for (Ellipsoid& tool : tools) tool.center = world * tool.center;
    check(scene, tools, 500, {1e-11, 1e-7}, {}, world);
  }
}

TEST_F(SceneIndexOnEveryTarget, AtThreeSigma_vs_bruteforce) {
  test::Random random(83);
  SceneFilter filter;
  filter.sigma = 3.0;
  const GaussianScene scene = scene_of(sphere_of_splats(random, 20000));
  check(scene, tools_at_sphere(random, draws(500)), 2000, {}, filter);
}

TEST_F(SceneIndexOnEveryTarget, WhereItIsVisible_vs_bruteforce) {
  test::Random random(84);
  std::vector<Splat> splats = sphere_of_splats(random, 20000);
  for (std::size_t i = 0; i < splats.size(); ++i)
    splats[i].opacity = i % 20 == 0 ? 1.0 : random.uniform(0.2, 1.0);
  SceneFilter filter;
  filter.iso = 0.3;
  check(scene_of(splats), tools_at_sphere(random, draws(500)), 500, {}, filter);
  check(in_bytes(scene_of(splats)), tools_at_sphere(random, draws(500)), 500, {}, filter);
}

TEST_F(SceneIndexOnEveryTarget, WithMipSplattingsFilter_vs_bruteforce) {
  test::Random random(85);
  GaussianScene scene = scene_of(sphere_of_splats(random, 20000));
  for (std::size_t i = 0; i < scene.size(); ++i) {
    scene.filter_3d.push_back(i % 50 == 0 ? 0.0F : static_cast<float>(random.log_uniform(1e-5, 0.01)));
    if (i % 70 == 1) scene.scale[i][2] = 0.0F;  // its opacity becomes 0 where the filter is not 0
  }
  SceneFilter filter;
  filter.opacity_min = 0.01;
  check(scene, tools_at_sphere(random, draws(500)), 100, {}, filter);
  filter.iso = 0.02;
  check(in_logarithms(scene), tools_at_sphere(random, draws(500)), 100, {}, filter);
}

TEST_F(SceneIndexOnEveryTarget, InEveryEncoding_vs_bruteforce) {
  test::Random random(86);
  std::vector<Splat> splats = sphere_of_splats(random, 20000);
  for (std::size_t i = 0; i < splats.size(); i += 3)
    splats[i].sigma[i % 2] = 0.0;  // of logarithm minus infinity
  const GaussianScene linear = scene_of(splats);
  const std::vector<Ellipsoid> tools = tools_at_sphere(random, draws(500));
  check(linear, tools, 500);
  check(in_logarithms(linear), tools, 500);
  check(in_bytes(linear), tools, 500);
  check(in_bytes(in_logarithms(linear)), tools, 500);
}

// 2DGS writes discs: a third sigma of zero, seen from the face, the rim and everywhere.
TEST_F(SceneIndexOnEveryTarget, OfDiscs_vs_bruteforce) {
  test::Random random(87);
  std::vector<Splat> splats = sphere_of_splats(random, 20000);
  for (Splat& s : splats) s.sigma[2] = 0.0;
  check(scene_of(splats), tools_at_sphere(random, draws(1000)), 5000);
}

// Quaternions are not normalised in files.
TEST_F(SceneIndexOnEveryTarget, WithQuaternionsOfAnyLength_vs_bruteforce) {
  test::Random random(88);
  std::vector<Splat> splats = sphere_of_splats(random, 20000);
  for (Splat& s : splats) s.rotation *= random.either_sign(random.log_uniform(1e-6, 1e6));
  check(scene_of(splats), tools_at_sphere(random, draws(1000)), 5000);
}

TEST_F(SceneIndexOnEveryTarget, UnderAnisotropicTools_vs_bruteforce) {
  test::Random random(89);
  const GaussianScene scene = scene_of(sphere_of_splats(random, 20000));
  std::vector<Ellipsoid> tools;
  for (std::size_t i = 0; i < draws(90); ++i) {
    const Pose pose{random.vector(0.95, 1.05), random.rotation()};
    const Vector3d shapes[] = {{0.1, 0.001, 0.001}, {0.1, 0.1, 0.001}, {0.1, 0.01, 0.001}};
    tools.push_back(Ellipsoid::from_semi_axes(pose, shapes[i % 3]));
  }
  check(scene, tools, 300, {1e-11, 1e-6});
}

TEST_F(SceneIndexOnEveryTarget, OfNothingIsNeverTouched) {
  const SceneIndex nothing(GaussianScene{}, {}, {});
  const SceneIndex nothing_kept(scene_of({splat({0, 0, 0}, {1, 1, 1}, Eigen::Quaterniond::Identity(), 0.01)}),
                                {}, {});
  on_every_target([&] {
    for (const SceneIndex* index : {&nothing, &nothing_kept}) {
      ContactSet set;
      set.candidates = 7;
      set.contacts.emplace_back();
      index->query({{0, 0, 0}, Eigen::Matrix3d::Identity()}, set);
      EXPECT_TRUE(set.contacts.empty());
      EXPECT_EQ(set.candidates, 0U);
      EXPECT_EQ(set.filtered, 0U);
      EXPECT_EQ(index->size(), 0U);
    }
  });
}

// By hand: a tool of radius 1 at the origin.
TEST_F(SceneIndexOnEveryTarget, CountsTheStages) {
  const Vector3d small = Vector3d::Constant(0.125);
  const GaussianScene scene = with_gaps_in_ids(scene_of({
      splat({0.9, 0.9, 0.9}, small),            // boxes meet; 1.56 apart: spheres do not
      splat({0, 0, 1.0625}, small),             // touched
      splat({5, 0, 0}, small),                  // far
      splat({0.9, 0.9, 0}, {0.05, 0.05, 0.5}),  // spheres meet (1.27 < 1.5), solids do not
      splat({0, 0, -0.25}, small),              // touched
  }));
  const SceneIndex index(scene, {}, {});
  on_every_target([&] {
    ContactSet set;
    index.query({{0, 0, 0}, Eigen::Matrix3d::Identity()}, set);
    EXPECT_EQ(set.candidates, 5U);  // one block, all of it
    EXPECT_EQ(set.filtered, 3U);
    ASSERT_EQ(set.contacts.size(), 2U);
    EXPECT_EQ(set.contacts[0].id, 8U);   // 3 * 1 + 5
    EXPECT_EQ(set.contacts[1].id, 17U);  // 3 * 4 + 5
    EXPECT_NEAR(set.contacts[0].k_min, 1.0 - 1.0625 * 1.0625 / (1.125 * 1.125), 1e-14);
    EXPECT_NEAR(set.contacts[1].k_min, 1.0 - 0.0625 / (1.125 * 1.125), 1e-14);
    // Two balls: K is least at lambda = R / (R + r), the point on the line of centres.
    EXPECT_NEAR(set.contacts[0].lambda, 1.0 / 1.125, 1e-9);
    EXPECT_LE((set.contacts[0].normal - Vector3d(0, 0, -1)).norm(), 1e-9);
    EXPECT_NEAR(set.contacts[0].depth, 1.125 - 1.0625, 1e-12);
  });
}

// Balls, discs and needles as large as a planet to a finger: the sixth powers of size ratios that K is made
// of leave a float's range long before its sizes do.
TEST_F(SceneIndexOnEveryTarget, AGiantIsTouchedWhateverItsSize) {
  const auto touches = [](const SceneIndex& index, const Vector3d& center) {
    ContactSet set;
    index.query({center, Eigen::Matrix3d::Identity()}, set);
    return !set.contacts.empty();
  };
  for (double size = 1e3; size < 1e12; size *= 1.02) {
    const double large = static_cast<float>(size);
    for (const double small : {0.0, 1.0, 4.0, 16.0, large}) {
      SCOPED_TRACE(testing::Message() << large << " by " << small);
      const SceneIndex disc(scene_of({splat({0, 0, 0}, {large, large, small})}), {}, {});
      const SceneIndex needle(scene_of({splat({0, 0, 0}, {large, small, small})}), {}, {});
      on_every_target([&] {
        for (const SceneIndex* index : {&disc, &needle}) {
          EXPECT_TRUE(touches(*index, {0, 0, small + 0.9}));
          if (small < 1e9) {
            EXPECT_FALSE(touches(*index, {0, 0, small + 1.1}));
          }
        }
      });
    }
    if (HasFailure()) break;
  }
}

// Finite poses that single precision cannot hold, as a broken recording may have them. Nothing is there.
TEST_F(SceneIndexOnEveryTarget, AToolBeyondTheFloatsTouchesNothing) {
  test::Random random(91);
  const SceneIndex index(scene_of(sphere_of_splats(random, 1000)), {}, {});
  on_every_target([&] {
    ContactSet set;
    for (const double far : {1e20, 1e37, 1e38, 1e39, 1e150, 1e200, 1e308}) {
      for (const Vector3d& way : {Vector3d(1, 0, 0), Vector3d(0, -1, 0), Vector3d(1, -1, 1)}) {
        index.query({far * way, 0.02 * Eigen::Matrix3d::Identity()}, set);
        EXPECT_TRUE(set.contacts.empty()) << far;
      }
    }
  });
}

// And a tool that holds the scene many times over touches all of it.
TEST_F(SceneIndexOnEveryTarget, AToolLargerThanAllTouchesAll) {
  test::Random random(92);
  const GaussianScene scene = scene_of(sphere_of_splats(random, 1000));
  const SceneIndex index(scene, {}, {});
  on_every_target([&] {
    ContactSet set;
    for (const double size : {10.0, 1e3, 1e6, 1e12}) {
      index.query({{0, 0, 0}, size * Eigen::Matrix3d::Identity()}, set);
      EXPECT_EQ(set.contacts.size(), scene.size()) << size;
    }
  });
}

// The faintest and the most opaque that a logit can say.
TEST_F(SceneIndexOnEveryTarget, KeepsTheOpacityOfExtremeLogits) {
  std::vector<Splat> splats(40, splat({0, 0, 0}, Vector3d::Constant(0.1)));
  GaussianScene scene = scene_of(splats);
  for (std::size_t i = 0; i < scene.size(); ++i) scene.opacity[i] = 20.0F * (static_cast<float>(i) - 36.0F);
  scene.opacity[0] = -709.0F;  // alpha is 1e-308, all but nothing
  scene.opacity[1] = -707.0F;
  scene.opacity.back() = std::numeric_limits<float>::infinity();
  SceneFilter filter;
  filter.opacity_min = 0.0;
  check(scene, {{{0.05, 0, 0}, 0.1 * Eigen::Matrix3d::Identity()}}, 30, {}, filter);
}

TEST_F(SceneIndexOnEveryTarget, AnswersAllThreadsAlike) {
  test::Random random(90);
  const SceneIndex index(scene_of(sphere_of_splats(random, 20000)), {}, {});
  const std::vector<Ellipsoid> tools = random_tools(random, draws(400), 1.1, 0.02, 0.3);
  on_every_target([&] {
    std::vector<std::vector<Contact>> expected;
    ContactSet set;
    for (const Ellipsoid& tool : tools) {
      index.query(tool, set);
      expected.push_back(set.contacts);
    }
    std::vector<std::thread> threads;
    for (std::size_t first = 0; first < 8; ++first) {
      threads.emplace_back([&, first] {
        ContactSet own;
        for (std::size_t i = 0; i < tools.size(); ++i) {
          const std::size_t k = (i + 50 * first) % tools.size();
          index.query(tools[k], own);
          test::expect_equal(own.contacts, expected[k]);
        }
      });
    }
    for (std::thread& t : threads) t.join();
  });
}

}  // namespace
}  // namespace palpate

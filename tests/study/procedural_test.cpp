#include <palpate/study/procedural.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include <palpate/base/error.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

Vector3d splat_normal(const Gaussian& g) { return g.rotation * Vector3d::UnitZ(); }

std::vector<Vector3d> positions(const GaussianScene& scene) {
  std::vector<Vector3d> p(scene.size());
  for (std::size_t i = 0; i < p.size(); ++i) p[i] = scene.gaussian(i).position;
  return p;
}

double nearest_sample(const std::vector<Vector3d>& samples, const Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vector3d& s : samples) least = std::min(least, (s - p).squaredNorm());
  return std::sqrt(least);
}

/// Uniform in a box that holds every shape and some air around it.
Vector3d random_point(Random& random) {
  const double x = random.uniform(-0.5, 0.5);
  const double y = random.uniform(-0.4, 0.4);
  return {x, y, random.uniform(-0.5, 0.25)};
}

class EveryShape : public testing::TestWithParam<std::string_view> {
 protected:
  std::unique_ptr<AnalyticSurface> surface = make_surface(GetParam());
  double h = surface->default_spacing();
  GaussianScene scene = make_scene(*surface, {});
};

INSTANTIATE_TEST_SUITE_P(Procedural, EveryShape,
                         testing::ValuesIn(procedural_shapes().begin(), procedural_shapes().end()),
                         [](const auto& shape) { return std::string(shape.param); });

TEST_P(EveryShape, SamplesLieOnTheSurfaceWithItsNormal) {
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const Gaussian g = scene.gaussian(i);
    const NearestPoint truth = surface->project(g.position);
    ASSERT_NEAR(truth.distance, 0.0, 1e-6) << i;
    ASSERT_LT(g.sigma[2], 0.2 * g.sigma.head<2>().minCoeff()) << "the flattest axis is the local z axis";
    ASSERT_GT(splat_normal(g).dot(truth.normal), 1.0 - 1e-6) << i;
  }
}

TEST_P(EveryShape, HasNoHoles) {
  const std::vector<Vector3d> samples = positions(scene);
  Random random(7);
  for (int k = 0; k < 300; ++k) {
    const NearestPoint on_surface = surface->project(random_point(random));
    if (on_surface.distance < 0.0) continue;  // what is nearest from inside may be covered
    ASSERT_LT(nearest_sample(samples, on_surface.point), 1.2 * h) << on_surface.point.transpose();
  }
}

TEST_P(EveryShape, DistanceAgreesWithTheNearestSample) {
  const std::vector<Vector3d> samples = positions(scene);
  const bool single = surface->parts().size() == 1;
  Random random(8);
  for (int k = 0; k < 300; ++k) {
    const Vector3d p = random_point(random);
    const NearestPoint nearest = surface->project(p);
    ASSERT_EQ(nearest.distance, surface->distance(p));
    ASSERT_NEAR((p - nearest.point).norm(), std::abs(nearest.distance), 1e-12);
    ASSERT_NEAR(surface->distance(nearest.point), 0.0, 1e-12);
    ASSERT_NEAR(nearest.normal.norm(), 1.0, 1e-12);
    if (nearest.distance < 0.0 && !single) continue;
    const double d = std::abs(nearest.distance);
    const double brute = nearest_sample(samples, p);
    ASSERT_GT(brute, d - 1e-6) << p.transpose();
    ASSERT_LT(brute, d + 1.2 * h) << p.transpose();
  }
}

TEST_P(EveryShape, NormalIsTheGradientOfDistance) {
  constexpr double kStep = 1e-6;
  Random random(9);
  for (int k = 0; k < 300; ++k) {
    const Vector3d p = random_point(random);
    const NearestPoint nearest = surface->project(p);
    if (surface->closed()) {
      const double ahead = surface->distance(p + kStep * nearest.normal);
      ASSERT_NEAR((ahead - nearest.distance) / kStep, 1.0, 1e-4) << p.transpose();
    } else {
      ASSERT_GE(nearest.distance, surface->name() == "table" ? -1.0 : 0.0);
    }
  }
}

TEST_P(EveryShape, SameSeedSameScene) {
  const GaussianScene again = make_scene(*surface, {});
  EXPECT_EQ(scene.position, again.position);
  EXPECT_EQ(scene.scale, again.scale);
  EXPECT_EQ(scene.rotation, again.rotation);
  EXPECT_EQ(scene.opacity, again.opacity);
  EXPECT_EQ(scene.color, again.color);
  const GaussianScene other = make_scene(*surface, {.seed = 2});
  EXPECT_NE(scene.position, other.position);
  EXPECT_NE(scene.opacity, other.opacity);
}

TEST_P(EveryShape, HoldsLegalGaussians) {
  double widest_share = 0.0;
  double narrowest_share = 1.0;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const Gaussian g = scene.gaussian(i);
    ASSERT_EQ(scene.id[i], i);
    ASSERT_EQ(defect(scene, i), Defect::kNone);
    ASSERT_NEAR(scene.rotation[i].norm(), 1.0F, 1e-6F);
    ASSERT_GE(g.opacity, 0.6 - 1e-6);
    ASSERT_LE(g.opacity, 0.99 + 1e-6);
    widest_share = std::max(widest_share, g.sigma.head<2>().maxCoeff() / h);
    narrowest_share = std::min(narrowest_share, g.sigma.head<2>().minCoeff() / h);
  }
  EXPECT_NEAR(widest_share, 0.65 * 1.2, 0.01);
  const double finest = GetParam() == "step" ? 0.5 : 1.0;  // the riser is half as wide as h
  EXPECT_NEAR(narrowest_share, finest * 0.65 * 0.8, 0.01);
  EXPECT_EQ(scene.color.size(), scene.size());
}

/// Counts the samples of `shape` at 2 mm where `inside` holds against those that `area` asks for.
void expect_density(std::string_view shape, double area, const std::function<bool(const Vector3d&)>& inside) {
  constexpr double kSpacing = 0.002;
  const GaussianScene scene = make_scene(*make_surface(shape), {.spacing = kSpacing});
  const auto p = positions(scene);
  const auto count = static_cast<double>(std::ranges::count_if(p, inside));
  EXPECT_NEAR(count * kSpacing * kSpacing / area, 1.0, 0.03) << shape;
}

TEST(ProceduralDensity, SphereIsEquallyDenseFromPoleToPole) {
  constexpr double kSlice = 0.3 / 5.0;  // slices of equal height have equal area (Archimedes)
  for (int k = 0; k < 5; ++k) {
    expect_density("sphere", 2.0 * pi * 0.15 * kSlice, [=](const Vector3d& p) {
      return p[2] >= -0.15 + k * kSlice && p[2] < -0.15 + (k + 1) * kSlice;
    });
  }
  expect_density("sphere", 2.0 * pi * 0.15 * 0.01, [](const Vector3d& p) { return p[2] > 0.14; });
  expect_density("sphere", pi * 0.15 * 0.15, [](const Vector3d& p) { return p[0] > 0.0 && p[1] > 0.0; });
}

TEST(ProceduralDensity, TorusIsEquallyDenseInsideAndOutside) {
  constexpr double R = 0.12;
  constexpr double r = 0.05;
  const auto rho = [](const Vector3d& p) { return std::hypot(p[0], p[1]); };
  expect_density("torus", 2.0 * pi * r * (pi * R + 2.0 * r), [=](const Vector3d& p) { return rho(p) > R; });
  expect_density("torus", 2.0 * pi * r * (pi * R - 2.0 * r), [=](const Vector3d& p) { return rho(p) < R; });
  expect_density("torus", pi * pi * R * r, [](const Vector3d& p) { return p[0] > 0.0 && p[1] < 0.0; });
}

TEST(ProceduralDensity, FlatFacesAndCapsHaveTheirShare) {
  const double cap = pi * 0.1 * 0.1;
  expect_density("cylinder", cap, [](const Vector3d& p) { return p[2] > 0.15 - 1e-6; });
  expect_density("cylinder", cap, [](const Vector3d& p) { return p[2] < -0.15 + 1e-6; });
  expect_density("cylinder", 0.25 * cap,
                 [](const Vector3d& p) { return p[2] > 0.15 - 1e-6 && p.head<2>().norm() < 0.05; });
  expect_density("cylinder", 2.0 * pi * 0.1 * 0.3,
                 [](const Vector3d& p) { return std::abs(p[2]) < 0.15 - 1e-6; });
  expect_density("box", 0.3 * 0.2, [](const Vector3d& p) { return p[2] > 0.08 - 1e-6; });
  expect_density("box", 0.3 * 0.16, [](const Vector3d& p) { return p[1] < -0.1 + 1e-6; });
  expect_density("box", 0.2 * 0.16, [](const Vector3d& p) { return p[0] < -0.15 + 1e-6; });
  expect_density("plane", 0.04, [](const Vector3d& p) { return p[0] > 0.0 && p[1] < 0.0; });
  expect_density("step", 0.08, [](const Vector3d& p) { return std::abs(p[2]) < 1e-6; });
  expect_density("step", 0.08, [](const Vector3d& p) { return std::abs(p[2] - 0.003) < 1e-6; });
  expect_density("shell", pi * 0.15 * 0.15, [](const Vector3d& p) { return p[2] < 0.075; });
  expect_density("shell", pi * 0.15 * 0.15, [](const Vector3d& p) { return p[2] > 0.075; });
}

TEST(ProceduralDensity, InnermostRingOfACapIsNotDenserTowardsItsCentre) {
  constexpr double kRadius = 0.1;
  constexpr double kRing = kRadius / 20.0;
  const auto cylinder = make_cylinder(kRadius, 0.3);
  Random random(4);
  std::vector<SurfaceSample> samples;
  for (int k = 0; k < 100; ++k) cylinder->sample(kRing, random, samples);
  double sum_shares = 0.0;
  int count = 0;
  for (const SurfaceSample& s : samples) {
    const double share = s.point.head<2>().squaredNorm() / (kRing * kRing);  // of the ring's area, further in
    if (share > 1.0) continue;
    sum_shares += share;
    ++count;
  }
  EXPECT_EQ(count, 2 * 3 * 100);
  EXPECT_NEAR(sum_shares / count, 0.5, 0.03);
}

TEST(Procedural, SpacingSetsTheCount) {
  for (const double h : {0.02, 0.007, 0.003}) {
    const auto surface = make_surface("sphere");
    const auto count = static_cast<double>(make_scene(*surface, {.spacing = h}).size());
    EXPECT_NEAR(count, surface->area() / (h * h), 1.0);
  }
}

TEST(Procedural, RiserOfTheStepIsCoveredBySplatsOfItsOwnSize) {
  const GaussianScene scene = make_scene(*make_surface("step"), {});
  std::size_t on_riser = 0;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const Gaussian g = scene.gaussian(i);
    if (splat_normal(g)[0] > -0.9) continue;
    ++on_riser;
    EXPECT_LT(g.sigma.maxCoeff(), 0.0024) << "a larger one would stick out of the 3 mm face";
  }
  EXPECT_NEAR(static_cast<double>(on_riser), 0.4 / 0.003, 1.0);
}

struct SignedPoint {
  const char* shape;
  Vector3d p;
  double distance;
};

TEST(Procedural, DistancesAtKnownPoints) {
  const SignedPoint cases[] = {
      {"sphere", {0, 0, 0}, -0.15},
      {"sphere", {0.2, 0, 0}, 0.05},
      {"plane", {0.1, 0.1, 0.02}, 0.02},
      {"plane", {0.1, 0.1, -0.02}, 0.02},
      {"plane", {0.23, 0.24, 0.0}, 0.05},
      {"box", {0, 0, 0}, -0.08},
      {"box", {0.13, 0, 0}, -0.02},
      {"box", {0.18, 0.14, 0}, 0.05},
      {"box", {0.17, 0.12, 0.09}, 0.03},
      {"cylinder", {0, 0, 0}, -0.1},
      {"cylinder", {0, 0, 0.14}, -0.01},
      {"cylinder", {0.13, 0, 0.19}, 0.05},
      {"torus", {0, 0, 0}, 0.07},
      {"torus", {0, 0.12, 0}, -0.05},
      {"torus", {0, 0.15, 0.04}, 0.0},
      {"step", {-0.1, 0, 0.01}, 0.01},
      {"step", {0.1, 0, 0.01}, 0.007},
      {"step", {-0.001, 0, 0.002}, 0.001},
      {"step", {0.1, 0, 0.001}, 0.002},
      {"shell", {0, 0, 0}, 0.15},
      {"shell", {0, 0, 0.1}, 0.05},
      {"shell", {0, 0, 0.2}, 0.05},
      {"shell", {0.12, 0, -0.04}, 0.05},
      {"table", {0.1, 0.0, 0.005}, 0.005},
      {"table", {0.1, 0.0, -0.005}, -0.005},
      {"table", {-0.25, 0.14, 0.06}, -0.06},  // in the ball
      {"table", {-0.26, -0.12, 0.05}, 0.05},  // in the bowl: 50 mm above its lowest point
      {"table", {-0.26, -0.12, 0.08}, 0.08},  // its centre
      {"table", {0.36, 0.26, -0.2}, -0.02},   // in a leg
      {"table", {0.0, 0.0, -0.2}, 0.17},      // below the top
  };
  for (const SignedPoint& c : cases)
    EXPECT_NEAR(make_surface(c.shape)->distance(c.p), c.distance, 1e-12) << c.shape << " " << c.p.transpose();
}

TEST(Procedural, SolidsAreClosedAndSheetsAreNot) {
  for (const char* solid : {"sphere", "box", "cylinder", "torus"})
    EXPECT_TRUE(make_surface(solid)->closed()) << solid;
  for (const char* sheet : {"plane", "step", "shell", "table"})
    EXPECT_FALSE(make_surface(sheet)->closed()) << sheet;
}

TEST(Procedural, NoiseMovesAlongTheNormalByItsStandardDeviation) {
  constexpr double kNoise = 0.0015;
  const auto surface = make_surface("torus");
  const GaussianScene scene = make_scene(*surface, {.spacing = 0.003, .noise = kNoise});
  double sum = 0.0;
  double sum_squares = 0.0;
  for (const Vector3d& p : positions(scene)) {
    const double d = surface->distance(p);
    sum += d;
    sum_squares += d * d;
  }
  const auto n = static_cast<double>(scene.size());
  EXPECT_NEAR(sum / n, 0.0, 4.0 * kNoise / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(sum_squares / n), kNoise, 4.0 * kNoise / std::sqrt(2.0 * n));
}

TEST(Procedural, TiltTurnsTheNormalByItsStandardDeviation) {
  constexpr double kTilt = 0.17;
  const auto surface = make_surface("sphere");
  const GaussianScene scene = make_scene(*surface, {.spacing = 0.003, .tilt = kTilt});
  double sum_squares = 0.0;
  Vector3d mean_lean = Vector3d::Zero();
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const Gaussian g = scene.gaussian(i);
    const NearestPoint truth = surface->project(g.position);
    EXPECT_NEAR(truth.distance, 0.0, 1e-6);
    const Vector3d lean = truth.normal.cross(splat_normal(g));
    const double angle = std::atan2(lean.norm(), truth.normal.dot(splat_normal(g)));
    sum_squares += angle * angle;
    mean_lean += lean;
  }
  const auto n = static_cast<double>(scene.size());
  EXPECT_NEAR(std::sqrt(sum_squares / n), kTilt, 4.0 * kTilt / std::sqrt(2.0 * n));
  EXPECT_LT((mean_lean / n).norm(), 5.0 * kTilt / std::sqrt(n)) << "no direction is preferred";
}

TEST(Procedural, SplatsAreTurnedAtRandomInTheirPlane) {
  const GaussianScene scene = make_scene(*make_surface("plane"), {});
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < scene.size(); ++i)
    sum += (scene.gaussian(i).rotation * Vector3d::UnitX()).head<2>();
  EXPECT_LT(sum.norm() / static_cast<double>(scene.size()),
            4.0 / std::sqrt(static_cast<double>(scene.size())));
}

TEST(ProceduralTable, HasEveryObjectInItsOwnColor) {
  const auto surface = make_surface("table");
  const GaussianScene scene = make_scene(*surface, {});
  EXPECT_GE(scene.size(), 60'000U);
  EXPECT_LE(scene.size(), 150'000U);
  std::set<std::array<std::uint8_t, 3>> object_colors;
  for (const SurfacePart& part : surface->parts()) {
    const auto count = static_cast<double>(std::ranges::count(scene.color, part.color));
    EXPECT_GT(count, 0.4 * part.shape->area() / std::pow(surface->default_spacing(), 2)) << part.name;
    if (part.name == "top" || part.name == "leg") continue;
    EXPECT_TRUE(object_colors.insert(part.color).second) << part.name;
  }
  EXPECT_EQ(object_colors.size(), 7U);
}

TEST(ProceduralTable, PartsTouchButDoNotPenetrate) {
  const auto surface = make_surface("table");
  Random random(3);
  for (std::size_t i = 0; i < surface->parts().size(); ++i) {
    const SurfacePart& part = surface->parts()[i];
    std::vector<SurfaceSample> samples;
    part.shape->sample(0.004, random, samples);
    double least = std::numeric_limits<double>::infinity();
    for (const SurfaceSample& s : samples) {
      const Vector3d p = part.pose.orientation * s.point + part.pose.position;
      for (const SurfacePart& other : surface->parts()) {
        if (&other == &part) continue;
        const Vector3d local = other.pose.orientation.conjugate() * (p - other.pose.position);
        least = std::min(least, other.shape->nearest(local).distance);
      }
    }
    EXPECT_GT(least, -1e-12) << part.name;
    EXPECT_LT(least, 1e-3) << part.name << " floats in the air";
  }
}

TEST(ProceduralTable, CoveredFacesAreLeftOut) {
  const auto surface = make_surface("table");
  const GaussianScene scene = make_scene(*surface, {});
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const Gaussian g = scene.gaussian(i);
    const bool between_crate_and_top = std::abs(g.position[2]) < 1e-6 &&
                                       std::abs(g.position[0] - 0.22) < 0.04 &&
                                       std::abs(g.position[1] - 0.14) < 0.03;
    EXPECT_FALSE(between_crate_and_top) << g.position.transpose();
  }
}

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Procedural, UnknownShapeIsNamedWithTheKnownOnes) {
  const std::string message = message_of([] { make_surface("teapot"); });
  EXPECT_THAT(message, testing::HasSubstr("teapot"));
  for (const std::string_view shape : procedural_shapes())
    EXPECT_THAT(message, testing::HasSubstr(std::string(shape)));
}

TEST(Procedural, OptionsOutOfRangeAreRefused) {
  const auto surface = make_surface("sphere");
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double spacing : {0.0, -0.006, kNan, kInfinity}) {
    EXPECT_THAT(message_of([&] { make_scene(*surface, {.spacing = spacing}); }),
                testing::HasSubstr("spacing"));
  }
  for (const double bad : {-1e-9, kNan, kInfinity}) {
    EXPECT_THAT(message_of([&] { make_scene(*surface, {.noise = bad}); }), testing::HasSubstr("noise"));
    EXPECT_THAT(message_of([&] { make_scene(*surface, {.tilt = bad}); }), testing::HasSubstr("tilt"));
  }
}

TEST(Procedural, TooManyGaussiansAreRefusedBeforeTheyAreMade) {
  for (const double spacing : {1e-4, 1e-9, 1e-300}) {
    EXPECT_THAT(message_of([&] { make_scene(*make_surface("table"), {.spacing = spacing}); }),
                testing::HasSubstr("Gaussians"));
  }
}

TEST(Procedural, CoarseSpacingStillGivesEveryFace) {
  const GaussianScene scene = make_scene(*make_surface("box"), {.spacing = 10.0});
  std::set<std::pair<int, int>> faces;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    int axis = 0;
    const Vector3d n = splat_normal(scene.gaussian(i));
    n.cwiseAbs().maxCoeff(&axis);
    faces.insert({axis, n[axis] > 0.0});
  }
  EXPECT_EQ(faces.size(), 6U);
}

TEST(Random, IsTheGeneratorOfTheStandard) {
  Random random(5489);  // its default seed; the standard gives the 10,000th number
  for (int k = 1; k < 10'000; ++k) random.uniform();
  EXPECT_EQ(random.uniform(), static_cast<double>(9981545732273789042ULL >> 11) * 0x1p-53);
}

TEST(Random, NormalHasItsMoments) {
  Random random(1);
  constexpr int kDraws = 100'000;
  double m1 = 0.0, m2 = 0.0, m4 = 0.0;
  for (int k = 0; k < kDraws; ++k) {
    const double x = random.normal();
    m1 += x / kDraws;
    m2 += x * x / kDraws;
    m4 += x * x * x * x / kDraws;
  }
  EXPECT_NEAR(m1, 0.0, 0.015);
  EXPECT_NEAR(m2, 1.0, 0.02);
  EXPECT_NEAR(m4, 3.0, 0.15);
}

}  // namespace
}  // namespace palpate

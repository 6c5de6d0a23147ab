#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/study/capture_defects.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kSpacing = 0.004;

ProceduralOptions options(std::uint64_t seed = 1) {
  ProceduralOptions options;
  options.seed = seed;
  options.spacing = kSpacing;
  return options;
}

GaussianScene capture(const char* shape, const std::vector<std::string_view>& names, std::uint64_t seed = 1) {
  CaptureDefects defects;
  for (const std::string_view name : names) set_defect(defects, name);
  return make_capture(*make_surface(shape), options(seed), defects);
}

Vector3d at(const GaussianScene& scene, std::size_t i) { return scene.position[i].cast<double>(); }

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double deviation(const std::vector<double>& values) {
  const double middle = mean(values);
  double sum = 0.0;
  for (const double v : values) sum += (v - middle) * (v - middle);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double share_of(const std::vector<double>& values, double low, double high) {
  return static_cast<double>(std::ranges::count_if(values, [&](double v) { return v >= low && v < high; })) /
         static_cast<double>(values.size());
}

TEST(CaptureDefects, WithoutAnyTheSceneIsTheEvenOne) {
  const GaussianScene even = make_scene(*make_surface("box"), options()), scene = capture("box", {});
  EXPECT_EQ(scene.position, even.position);
  EXPECT_EQ(scene.scale, even.scale);
  EXPECT_EQ(scene.opacity, even.opacity);
}

TEST(CaptureDefects, AreTheSameEveryTimeAndOthersForAnotherSeed) {
  for (const std::string_view name : capture_defects()) {
    const GaussianScene one = capture("box", {name}), again = capture("box", {name}),
                        other = capture("box", {name}, 2);
    EXPECT_EQ(one.position, again.position) << name;
    EXPECT_EQ(one.scale, again.scale) << name;
    EXPECT_NE(one.position, other.position) << name;
    for (std::size_t i = 0; i < one.size(); ++i) {
      ASSERT_EQ(one.id[i], i) << name;
      ASSERT_EQ(defect(one, i), Defect::kNone) << name;
    }
    EXPECT_EQ(one.color.size(), one.size());
  }
  EXPECT_THROW(capture("box", {"dust"}), Error);
}

// Every stretched Gaussian against the same one of the even scene.
TEST(Tails, AreLogNormalWithLargeOnesAndNeedles) {
  const GaussianScene even = capture("box", {}), scene = capture("box", {"tails"});
  ASSERT_EQ(scene.size(), even.size());
  std::vector<double> stretched, thickness, aspect;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    stretched.push_back(scene.scale[i].x() - even.scale[i].x());
    thickness.push_back(scene.scale[i].z() - even.scale[i].z());
    aspect.push_back(scene.scale[i].x() - scene.scale[i].y());
  }
  EXPECT_NEAR(mean(stretched), 0.01 * std::log(5.0), 0.03);
  EXPECT_NEAR(deviation(stretched), 0.72, 0.03);
  EXPECT_EQ(deviation(thickness), 0.0);
  EXPECT_NEAR(share_of(aspect, std::log(9.99), std::log(10.01)), 0.02, 0.005);
}

TEST(Floaters, AreAFewFaintOnesInTheAir) {
  const auto surface = make_surface("box");
  const std::size_t even = capture("box", {}).size();
  const GaussianScene scene = capture("box", {"floaters"});
  EXPECT_NEAR(static_cast<double>(scene.size() - even), 0.02 * static_cast<double>(even), 1.0);
  std::vector<double> heights;
  for (std::size_t i = even; i < scene.size(); ++i) {
    const Gaussian g = scene.gaussian(i);
    heights.push_back(surface->distance(g.position));
    EXPECT_GT(heights.back(), 0.0);
    EXPECT_LT(heights.back(), 0.1);
    EXPECT_GE(g.opacity, 0.05 - 1e-6);
    EXPECT_LE(g.opacity, 0.4 + 1e-6);
    EXPECT_GE(g.sigma.minCoeff(), 0.3 * kSpacing - 1e-6);
    EXPECT_LE(g.sigma.maxCoeff(), 3.0 * kSpacing + 1e-6);
  }
  EXPECT_GT(share_of(heights, 0.05, 0.1), 0.4);  // not only at the surface
}

TEST(DoubleLayers, LieOnBothSidesAndAreHalfAsOpaque) {
  const GaussianScene even = capture("plane", {}), scene = capture("plane", {"double"});
  ASSERT_EQ(scene.size(), 2 * even.size());
  std::vector<double> heights, opacity;
  for (std::size_t i = even.size(); i < scene.size(); ++i) {
    heights.push_back(at(scene, i).z());
    opacity.push_back(scene.gaussian(i).opacity);
    EXPECT_GE(std::abs(heights.back()), 0.002 - 1e-6);
    EXPECT_LE(std::abs(heights.back()), 0.004 + 1e-6);
  }
  EXPECT_GT(share_of(heights, 0.0, 1.0), 0.15);
  EXPECT_GT(share_of(heights, -1.0, 0.0), 0.15);
  EXPECT_NEAR(mean(opacity), 0.5 * 0.5 * (0.6 + 0.99), 0.01);
}

// Lines of 50 mm in the air before a sheet, composited by what is nearest to them within.
TEST(Haze, TakesAFifthOfTheLightOver50mm) {
  const std::size_t even = capture("plane", {}).size();
  const GaussianScene scene = capture("plane", {"haze"});
  ASSERT_GT(scene.size(), even + 100);
  Random random(3);
  constexpr int kLines = 300;
  double optical = 0.0;
  for (int line = 0; line < kLines; ++line) {
    const Vector3d from{random.uniform(-0.15, 0.15), random.uniform(-0.15, 0.15), 0.02};
    for (std::size_t i = even; i < scene.size(); ++i) {
      const Gaussian g = scene.gaussian(i);
      const Eigen::Matrix3d whiten =
          g.sigma.cwiseInverse().asDiagonal() * g.rotation.toRotationMatrix().transpose();
      const Vector3d x = whiten * (from - g.position), d = whiten * Vector3d::UnitZ();
      const double s = -x.dot(d) / d.squaredNorm();
      if (s > 0.0 && s < 0.05)
        optical -= std::log(1.0 - g.opacity * std::exp(-0.5 * (x + s * d).squaredNorm()));
    }
  }
  EXPECT_NEAR(std::exp(-optical / kLines), 0.8, 0.04);
}

TEST(Holes, TakeATenthOfTheSurfaceAndAreSmall) {
  const GaussianScene even = capture("plane", {}), scene = capture("plane", {"holes"});
  EXPECT_NEAR(static_cast<double>(scene.size()) / static_cast<double>(even.size()), 0.9, 0.02);
  Random random(3);
  std::vector<double> empty;
  for (int k = 0; k < 500; ++k) {
    const Vector3d p{random.uniform(-0.19, 0.19), random.uniform(-0.19, 0.19), 0.0};
    double nearest = 1.0;
    for (std::size_t i = 0; i < scene.size(); ++i) nearest = std::min(nearest, (at(scene, i) - p).norm());
    empty.push_back(nearest / kSpacing);
  }
  EXPECT_GT(share_of(empty, 0.0, 2.0), 0.99);
  EXPECT_GT(share_of(empty, 1.06, 3.0), 0.01);  // where an even scene has none
}

// In sizes of the Gaussians neighbours are as far apart everywhere.
TEST(Density, VariesByAHundredAndTheSizesWithIt) {
  const GaussianScene scene = capture("box", {"density"});
  std::vector<double> sizes, apart;
  for (std::size_t i = 0; i < scene.size(); ++i) sizes.push_back(scene.gaussian(i).sigma.x() / kSpacing);
  EXPECT_LT(std::ranges::min(sizes), 0.65 * 1.1);
  EXPECT_GT(std::ranges::max(sizes), 0.65 * 9.0);
  for (std::size_t i = 0; i < scene.size(); i += 7) {
    double nearest = 1.0;
    for (std::size_t j = 0; j < scene.size(); ++j) {
      if (j != i) nearest = std::min(nearest, (at(scene, i) - at(scene, j)).norm());
    }
    apart.push_back(nearest / kSpacing / sizes[i]);
  }
  EXPECT_GT(share_of(apart, 0.5, 2.5), 0.85);
}

}  // namespace
}  // namespace palpate

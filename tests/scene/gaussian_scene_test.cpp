// Activation and defects.
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include <palpate/scene/gaussian_scene.h>

#include "support/not_finite.h"
#include "support/splats.h"

namespace palpate::test {
namespace {

/// One sound Gaussian in INRIA's encodings.
GaussianScene sound() {
  GaussianScene scene;
  scene.id = {0};
  scene.position = {{1, 2, 3}};
  scene.scale = {{-1, -2, -3}};
  scene.rotation = {{1, 2, 3, 4}};
  scene.opacity = {0.5F};
  return scene;
}

/// References to every number of the first Gaussian.
std::vector<std::reference_wrapper<float>> numbers_of(GaussianScene& scene) {
  std::vector<std::reference_wrapper<float>> numbers;
  for (float& v : scene.position[0]) numbers.emplace_back(v);
  for (float& v : scene.scale[0]) numbers.emplace_back(v);
  for (float& v : scene.rotation[0]) numbers.emplace_back(v);
  numbers.emplace_back(scene.opacity[0]);
  return numbers;
}

TEST(GaussianScene, ActivatesAsInriaTrains) {
  const Gaussian g = sound().gaussian(0);
  EXPECT_EQ(g.position, Eigen::Vector3d(1, 2, 3));
  EXPECT_DOUBLE_EQ(g.sigma.x(), std::exp(-1.0));
  EXPECT_DOUBLE_EQ(g.sigma.y(), std::exp(-2.0));
  EXPECT_DOUBLE_EQ(g.sigma.z(), std::exp(-3.0));
  EXPECT_DOUBLE_EQ(g.opacity, 0.62245933120185459);  // 1 / (1 + e^-1/2)
  const double norm = std::sqrt(30.0);
  EXPECT_DOUBLE_EQ(g.rotation.w(), 1 / norm);
  EXPECT_DOUBLE_EQ(g.rotation.x(), 2 / norm);
  EXPECT_DOUBLE_EQ(g.rotation.y(), 3 / norm);
  EXPECT_DOUBLE_EQ(g.rotation.z(), 4 / norm);
}

TEST(GaussianScene, AddsItsOrigin) {
  GaussianScene scene = sound();
  scene.origin = {500000, 0, -1};
  EXPECT_EQ(scene.gaussian(0).position, Eigen::Vector3d(500001, 2, 2));
}

TEST(GaussianScene, ActivatesLinearEncodings) {
  GaussianScene scene = sound();
  scene.scale_encoding = ScaleEncoding::kLinear;
  scene.opacity_encoding = OpacityEncoding::kByte;
  scene.opacity = {102};
  const Gaussian g = scene.gaussian(0);
  EXPECT_EQ(g.sigma, Eigen::Vector3d(1, 2, 3));  // |scale|
  EXPECT_DOUBLE_EQ(g.opacity, 0.4);
}

TEST(GaussianScene, ExtremeLogitsAreLegal) {
  GaussianScene scene = sound();
  for (const auto& [logit, alpha] :
       {std::pair{kFloatInfinity, 1.0}, {-kFloatInfinity, 0.0}, {800.0F, 1.0}, {-800.0F, 0.0}}) {
    scene.opacity[0] = logit;
    EXPECT_EQ(scene.gaussian(0).opacity, alpha);
    EXPECT_EQ(defect(scene, 0), Defect::kNone);
  }
}

TEST(GaussianScene, FiltersAsMipSplatting) {
  GaussianScene scene = scene_of({{{0, 0, 0}, {3, 0.75, 0}, 0.5}});
  scene.filter_3d = {4};
  Gaussian g = scene.gaussian(0);
  EXPECT_DOUBLE_EQ(g.sigma.x(), 5.0);
  EXPECT_DOUBLE_EQ(g.sigma.y(), std::sqrt(0.5625 + 16));
  EXPECT_DOUBLE_EQ(g.sigma.z(), 4.0);
  EXPECT_EQ(g.opacity, 0.0);  // a disc, smeared out, has no density left
  scene.filter_3d = {0};      // no filter changes nothing, not even a sigma of zero
  g = scene.gaussian(0);
  EXPECT_EQ(g.sigma, Eigen::Vector3d(3, 0.75, 0));
  EXPECT_EQ(g.opacity, 0.5);
}

TEST(Defect, ASoundGaussianHasNone) { EXPECT_EQ(defect(sound(), 0), Defect::kNone); }

TEST(Defect, NanInAnyNumber) {
  for (std::size_t k = 0; k < 11; ++k) {
    GaussianScene scene = sound();
    numbers_of(scene)[k].get() = kFloatNan;
    EXPECT_EQ(defect(scene, 0), Defect::kNan) << k;
  }
  GaussianScene scene = sound();
  scene.filter_3d = {kFloatNan};
  EXPECT_EQ(defect(scene, 0), Defect::kNan);
}

TEST(Defect, InfinityInAnyNumberButTheOpacity) {
  for (std::size_t k = 0; k < 10; ++k) {
    for (const float infinity : {kFloatInfinity, -kFloatInfinity}) {
      GaussianScene scene = sound();
      numbers_of(scene)[k].get() = infinity;
      const bool log_of_zero = infinity < 0 && k >= 3 && k < 6;
      EXPECT_EQ(defect(scene, 0), log_of_zero ? Defect::kNone : Defect::kInfinite) << k;
    }
  }
  GaussianScene scene = sound();
  scene.filter_3d = {kFloatInfinity};
  EXPECT_EQ(defect(scene, 0), Defect::kInfinite);
}

TEST(Defect, SizesThatOverflowCountAsInfinite) {
  GaussianScene scene = sound();
  scene.position[0].y() = -1e30F;
  EXPECT_EQ(defect(scene, 0), Defect::kInfinite);
  scene.position[0].y() = 9e11F;
  EXPECT_EQ(defect(scene, 0), Defect::kNone);
  scene.scale[0].x() = 27.0F;  // e^27 = 5.3e11
  EXPECT_EQ(defect(scene, 0), Defect::kNone);
  scene.scale[0].x() = 28.0F;  // e^28 = 1.4e12
  EXPECT_EQ(defect(scene, 0), Defect::kInfinite);
}

TEST(Defect, ZeroQuaternion) {
  GaussianScene scene = sound();
  scene.rotation[0].setZero();
  EXPECT_EQ(defect(scene, 0), Defect::kZeroQuaternion);
  scene.rotation[0][2] = -0.0F;
  EXPECT_EQ(defect(scene, 0), Defect::kZeroQuaternion);
  scene.rotation[0][2] = std::numeric_limits<float>::denorm_min();  // an orientation, if barely
  EXPECT_EQ(defect(scene, 0), Defect::kNone);
  EXPECT_DOUBLE_EQ(scene.gaussian(0).rotation.y(), 1.0);
}

TEST(Defect, ZeroScaleIsAllThree) {
  GaussianScene scene = sound();
  for (const int axis : {0, 1}) {
    scene.scale[0][axis] = -kFloatInfinity;
    EXPECT_EQ(defect(scene, 0), Defect::kNone);
  }
  scene.scale[0][2] = -1000.0F;  // underflows
  EXPECT_EQ(defect(scene, 0), Defect::kZeroScale);
}

TEST(Defect, TheFirstInOrderCounts) {
  GaussianScene scene = sound();
  scene.rotation[0].setZero();
  scene.scale[0].setConstant(-kFloatInfinity);
  EXPECT_EQ(defect(scene, 0), Defect::kZeroQuaternion);
  scene.position[0].x() = kFloatInfinity;
  EXPECT_EQ(defect(scene, 0), Defect::kInfinite);
  scene.opacity[0] = kFloatNan;
  EXPECT_EQ(defect(scene, 0), Defect::kNan);
}

TEST(Defect, HasAWordForEach) {
  EXPECT_STREQ(to_string(Defect::kNone), "none");
  EXPECT_STREQ(to_string(Defect::kNan), "nan");
  EXPECT_STREQ(to_string(Defect::kInfinite), "infinite");
  EXPECT_STREQ(to_string(Defect::kZeroQuaternion), "zero_quaternion");
  EXPECT_STREQ(to_string(Defect::kZeroScale), "zero_scale");
}

}  // namespace
}  // namespace palpate::test

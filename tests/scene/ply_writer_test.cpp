// What is written is INRIA's layout, and reads back as it was.
#include <cmath>
#include <filesystem>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/scene/load_scene.h>
#include <palpate/scene/ply_writer.h>

#include "support/not_finite.h"
#include "support/splats.h"
#include "support/temporary_file.h"

namespace palpate::test {
namespace {

GaussianScene written_and_read(const GaussianScene& scene) {
  const TemporaryFile file("", "out.ply");
  write_ply(scene, file.path(), "made by a test");
  return load_scene(file.path());
}

GaussianScene random_scene(int count) {
  std::mt19937 random(11);
  std::normal_distribution<float> normal;
  GaussianScene scene;
  for (int k = 0; k < count; ++k) {
    scene.id.push_back(static_cast<std::uint32_t>(k));
    scene.position.push_back({normal(random), normal(random), normal(random)});
    scene.scale.push_back({normal(random) - 4, normal(random) - 4, normal(random) - 8});
    scene.rotation.push_back({normal(random), normal(random), normal(random), normal(random)});
    scene.opacity.push_back(3 * normal(random));
  }
  return scene;
}

void expect_same_gaussian(const Gaussian& a, const Gaussian& b) {
  constexpr double kFloat = 1.2e-7;
  EXPECT_LE((a.position - b.position).norm(), kFloat * a.position.norm());
  EXPECT_NEAR(a.opacity, b.opacity, 2 * kFloat);
  for (int axis = 0; axis < 3; ++axis) {
    // sigma = exp(scale): a float's rounding of a scale of up to 16 is 1e-6 of the sigma
    EXPECT_LE(std::abs(a.sigma[axis] - b.sigma[axis]), 1e-6 * a.sigma[axis]);
  }
  EXPECT_GE(std::abs(a.rotation.dot(b.rotation)), 1 - 1e-12);
}

TEST(PlyWriter, WritesInriasHeader) {
  const TemporaryFile file("", "out.ply");
  write_ply(scene_of({{}, {}}), file.path(), "made by a test");
  const std::string expected =
      "ply\nformat binary_little_endian 1.0\ncomment made by a test\nelement vertex 2\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\n"
      "property float opacity\nproperty float scale_0\nproperty float scale_1\nproperty float scale_2\n"
      "property float rot_0\nproperty float rot_1\nproperty float rot_2\nproperty float rot_3\nend_header\n";
  const std::string bytes = file.bytes();
  EXPECT_EQ(bytes.substr(0, expected.size()), expected);
  EXPECT_EQ(bytes.size(), expected.size() + 2 * 17 * 4);
}

TEST(PlyWriter, ReadsBackToFloatRounding) {
  const GaussianScene scene = random_scene(500);
  const GaussianScene back = written_and_read(scene);
  ASSERT_EQ(back.size(), scene.size());
  EXPECT_EQ(back.trailing_bytes, 0U);
  for (std::size_t i = 0; i < scene.size(); ++i) expect_same_gaussian(scene.gaussian(i), back.gaussian(i));
}

TEST(PlyWriter, BakesTheOriginAndTheFilterIn) {
  GaussianScene scene = random_scene(100);
  scene.origin = {7, -8, 9};
  for (std::size_t i = 0; i < scene.size(); ++i) scene.filter_3d.push_back(0.001F * static_cast<float>(i));
  const GaussianScene back = written_and_read(scene);
  EXPECT_TRUE(back.filter_3d.empty());
  for (std::size_t i = 0; i < scene.size(); ++i) expect_same_gaussian(scene.gaussian(i), back.gaussian(i));
}

TEST(PlyWriter, KeepsExactZerosAndOnes) {
  GaussianScene scene = random_scene(3);
  scene.opacity = {kFloatInfinity, -kFloatInfinity, 0.0F};
  scene.scale[2] = {-1.0F, -kFloatInfinity, -2.0F};
  const GaussianScene back = written_and_read(scene);
  EXPECT_EQ(back.gaussian(0).opacity, 1.0);
  EXPECT_EQ(back.gaussian(1).opacity, 0.0);
  EXPECT_EQ(back.gaussian(2).opacity, 0.5);
  EXPECT_EQ(back.gaussian(2).sigma.y(), 0.0);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(defect(back, i), Defect::kNone);
}

TEST(PlyWriter, KeepsEveryColour) {
  GaussianScene scene = scene_of(std::vector<Splat>(256));
  for (int k = 0; k < 256; ++k)
    scene.color.push_back({static_cast<std::uint8_t>(k), static_cast<std::uint8_t>(255 - k), 0});
  EXPECT_EQ(written_and_read(scene).color, scene.color);
}

TEST(PlyWriter, DefectsStayDefects) {
  GaussianScene scene = random_scene(4);
  scene.position[0].x() = kFloatNan;
  scene.position[1].y() = kFloatInfinity;
  scene.scale[2].setConstant(-kFloatInfinity);
  scene.scale[3].x() = kFloatInfinity;
  const GaussianScene back = written_and_read(scene);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NE(defect(back, i), Defect::kNone) << i;
}

TEST(PlyWriter, AFailureNamesTheFileAndLeavesNothing) {
  const TemporaryFile file("");
  const std::string path = (file.folder() / "missing" / "out.ply").string();
  EXPECT_NE(message_of<Error>([&] { write_ply(scene_of({{}}), path, "x"); }).find(path), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace palpate::test

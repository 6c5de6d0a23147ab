// The .splat reader against records made by hand.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/scene/splat_reader.h>

#include "support/ply_builder.h"
#include "support/temporary_file.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

std::string record(std::initializer_list<double> numbers, std::initializer_list<int> bytes) {
  std::string out;
  for (const double v : numbers) out += bytes_as<float>(v, false);
  for (const int b : bytes) out += static_cast<char>(b);
  EXPECT_EQ(out.size(), 32U);
  return out;
}

GaussianScene read_records(const std::string& bytes) {
  const TemporaryFile file(bytes, "scene.splat");
  return read_splat(InputFile(file.path()));
}

TEST(SplatReader, ReadsARecordByHand) {
  const GaussianScene scene =
      read_records(record({1.5, -2, 3, 0.1, 0.2, 0.4}, {10, 128, 255, 51, 255, 0, 128, 192}) +
                   record({7, 8, 9, 1, 1, 0}, {0, 0, 0, 255, 128, 128, 128, 255}));
  ASSERT_EQ(scene.size(), 2U);
  EXPECT_EQ(scene.id[1], 1U);
  EXPECT_EQ(scene.position[0], Eigen::Vector3f(1.5F, -2, 3));
  EXPECT_EQ(scene.color[0], (std::array<std::uint8_t, 3>{10, 128, 255}));
  EXPECT_EQ(scene.rotation[0], Eigen::Vector4f(127.0F / 128, -1, 0, 0.5F));

  const Gaussian g = scene.gaussian(0);
  EXPECT_NEAR(g.sigma.x(), 0.1, 1e-8);
  EXPECT_NEAR(g.sigma.z(), 0.4, 1e-7);
  EXPECT_EQ(g.opacity, 0.2);  // 51 / 255
  const double norm = std::sqrt(127.0 * 127 / (128.0 * 128) + 1 + 0.25);
  EXPECT_NEAR(g.rotation.w(), 127.0 / 128 / norm, 1e-15);
  EXPECT_NEAR(g.rotation.x(), -1 / norm, 1e-15);
  EXPECT_EQ(scene.gaussian(1).opacity, 1.0);
  EXPECT_EQ(scene.gaussian(1).sigma.z(), 0.0);  // a disc
  EXPECT_EQ(defect(scene, 1), Defect::kNone);
}

TEST(SplatReader, FindsDefects) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const GaussianScene scene = read_records(record({nan, 0, 0, 1, 1, 1}, {0, 0, 0, 9, 255, 128, 128, 128}) +
                                           record({0, 0, 0, 1, 1, 1}, {0, 0, 0, 9, 128, 128, 128, 128}) +
                                           record({0, 0, 0, 0, 0, 0}, {0, 0, 0, 9, 255, 128, 128, 128}) +
                                           record({0, 0, 0, 1e30, 1, 1}, {0, 0, 0, 9, 255, 128, 128, 128}));
  EXPECT_EQ(defect(scene, 0), Defect::kNan);
  EXPECT_EQ(defect(scene, 1), Defect::kZeroQuaternion);
  EXPECT_EQ(defect(scene, 2), Defect::kZeroScale);
  EXPECT_EQ(defect(scene, 3), Defect::kInfinite);
}

TEST(SplatReader, RefusesSizesThatAreNoMultipleOfARecord) {
  const std::string one = record({1, 2, 3, 1, 1, 1}, {1, 2, 3, 255, 255, 128, 128, 128});
  for (std::size_t size = 1; size < 96; ++size) {
    if (size % 32 == 0) continue;
    const TemporaryFile file((one + one + one).substr(0, size), "cut.splat");
    const std::string message = message_of<Error>([&] { read_splat(InputFile(file.path())); });
    EXPECT_THAT(message, HasSubstr(file.path()));
    EXPECT_THAT(message, HasSubstr("byte " + std::to_string(size)));
    EXPECT_THAT(message, HasSubstr("Gaussian " + std::to_string(size / 32)));
  }
}

TEST(SplatReader, FindsRecordsAcrossItsReadBuffers) {
  constexpr int kCount = (1 << 16) * 2 + 5;
  std::string bytes;
  for (int k = 0; k < kCount; ++k)
    bytes += record({k * 1.0, 0, 0, 1, 1, 1}, {0, 0, 0, 9, 255, 128, 128, 128});
  const GaussianScene scene = read_records(bytes);
  ASSERT_EQ(scene.size(), static_cast<std::size_t>(kCount));
  for (std::size_t k = 0; k < scene.size(); ++k) {
    ASSERT_EQ(scene.position[k].x(), static_cast<float>(k));
    ASSERT_EQ(scene.id[k], k);
  }
}

}  // namespace
}  // namespace palpate::test

#include <cmath>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/scene/load_scene.h>
#include <palpate/scene/ply_materials.h>
#include <palpate/scene/scene_reader.h>
#include <support/ply_builder.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using test::Encoding;
using test::message_of;
using test::PlyFile;
using test::TemporaryFile;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

PlyMaterials materials_of(const std::string& bytes) {
  return read_ply_materials(TemporaryFile(bytes, "m.ply").path());
}

/// Three Gaussians with `stiffness` between other properties and `damping` at the end.
PlyFile some_file(const std::string& type) {
  PlyFile file = test::inria_file(3);
  file.properties.insert(file.properties.begin() + 5, {"stiffness", type});
  file.properties.push_back({"damping", type});
  for (std::size_t k = 0; k < 3; ++k) {
    file.rows[k]["stiffness"] = 100.0 + static_cast<double>(k);
    file.rows[k]["damping"] = static_cast<double>(k);
  }
  return file;
}

TEST(PlyMaterials, AreReadFromAnyEncodingAndType) {
  for (const Encoding encoding : test::kEncodings) {
    for (const char* type : {"float", "double", "uchar", "int16", "uint"}) {
      PlyFile file = some_file(type);
      file.encoding = encoding;
      const PlyMaterials materials = materials_of(file.bytes());
      EXPECT_THAT(materials.values[kMaterialStiffness], ElementsAre(100, 101, 102)) << type;
      EXPECT_THAT(materials.values[kMaterialFriction], IsEmpty());
      EXPECT_THAT(materials.values[kMaterialDamping], ElementsAre(0, 1, 2)) << type;
      EXPECT_FALSE(materials.empty());
    }
  }
}

TEST(PlyMaterials, AreFoundBehindOtherElements) {
  PlyFile file = some_file("float");
  file.header_before = "element camera 1\nproperty list uchar short v\n";
  file.data_before = std::string("\x02\x01\x02\x03\x04", 5);
  EXPECT_THAT(materials_of(file.bytes()).values[kMaterialStiffness], ElementsAre(100, 101, 102));
}

TEST(PlyMaterials, LeaveTheSceneAsItIs) {
  const PlyFile plain = test::inria_file(3);
  const TemporaryFile with(some_file("float").bytes(), "m.ply"), without(plain.bytes(), "p.ply");
  const GaussianScene a = load_scene(with.path()), b = load_scene(without.path());
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.scale, b.scale);
  EXPECT_EQ(a.opacity, b.opacity);
  EXPECT_THAT(a.format, HasSubstr("with stiffness, damping"));
  EXPECT_THAT(b.format, Not(HasSubstr("with")));
}

TEST(PlyMaterials, AreNoneWithoutTheProperties) {
  EXPECT_TRUE(materials_of(test::inria_file(3).bytes()).empty());
  EXPECT_TRUE(materials_of(std::string(64, '\0')).empty());  // a .splat
  EXPECT_TRUE(materials_of("").empty());
  // Only the header is read: that the data are cut is not seen.
  const std::string cut = test::inria_file(3).bytes();
  EXPECT_TRUE(materials_of(cut.substr(0, cut.size() - 1)).empty());
}

TEST(PlyMaterials, NotANumberIsNotSet) {
  for (const Encoding encoding : test::kEncodings) {
    PlyFile file = some_file("float");
    file.encoding = encoding;
    file.rows[1]["stiffness"] = kNaN;
    const PlyMaterials materials = materials_of(file.bytes());
    EXPECT_EQ(materials.values[kMaterialStiffness][0], 100.0F);
    EXPECT_TRUE(std::isnan(materials.values[kMaterialStiffness][1]));
  }
}

TEST(PlyMaterials, AreCountedAcrossChunks) {
  const int count = static_cast<int>(SceneReader::kChunk) + 3;
  PlyFile file;
  file.properties = test::bare_properties();
  file.properties.push_back({"friction", "float"});
  for (int k = 0; k < count; ++k) file.rows.push_back({{"friction", (k % 1000) / 128.0}, {"rot_0", 1.0}});
  const auto values = materials_of(file.bytes()).values[kMaterialFriction];
  ASSERT_EQ(values.size(), static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) ASSERT_EQ(values[static_cast<std::size_t>(k)], (k % 1000) / 128.0) << k;
}

TEST(PlyMaterials, TakeTheBoundsAndNothingBeyond) {
  const auto with = [](double value) {
    PlyFile file = some_file("double");
    file.rows[1]["stiffness"] = value;
    return file.bytes();
  };
  EXPECT_EQ(materials_of(with(0.0)).values[kMaterialStiffness][1], 0.0F);
  EXPECT_EQ(materials_of(with(1e6)).values[kMaterialStiffness][1], 1e6F);
  for (const double bad : {-1.0, -0.001, 1.001e6, 1e300, HUGE_VAL, -HUGE_VAL}) {
    EXPECT_THAT(
        message_of<Error>([&] { materials_of(with(bad)); }),
        AllOf(HasSubstr("m.ply: Gaussian 1: property 'stiffness'"), HasSubstr("from 0 to 1000000 N/m")))
        << bad;
  }
}

TEST(PlyMaterials, RefuseWhatTheSceneReaderRefuses) {
  const std::string bytes = some_file("float").bytes();
  EXPECT_THAT(message_of<Error>([&] { materials_of(bytes.substr(0, bytes.size() - 1)); }),
              HasSubstr("ends inside Gaussian 2 of 3"));
  PlyFile list = some_file("float");
  list.property("stiffness").type = "list uchar float";
  EXPECT_THAT(message_of<Error>([&] { materials_of(list.bytes()); }), HasSubstr("'stiffness' is a list"));
}

}  // namespace
}  // namespace palpate

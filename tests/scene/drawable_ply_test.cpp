// Which scene files the viewer draws as they are, and what it is given in place of the others.
#include <palpate/scene/drawable_ply.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/scene/load_scene.h>

#include "support/ply_builder.h"
#include "support/temporary_file.h"

namespace palpate::test {
namespace {

/// A scene with f_rest_* of `degree`, each number of which is another.
PlyFile with_sh(int degree) {
  PlyFile file = inria_file(5);
  for (int k = 0; k < 3 * ((degree + 1) * (degree + 1) - 1); ++k) {
    const std::string name = fmt::format("f_rest_{}", k);
    file.properties.push_back({name});
    for (std::size_t i = 0; i < file.rows.size(); ++i) file.rows[i][name] = 0.01 * k + static_cast<double>(i);
  }
  return file;
}

bool draws(const std::string& bytes) { return is_drawable(TemporaryFile(bytes, "scene.ply").path()); }

/// What write_drawable_ply() makes of `file`.
struct Copy {
  explicit Copy(const PlyFile& file) : of(file.bytes(), "scene.ply") {
    write_drawable_ply(of.path(), to.path());
    text = read_text_file(to.path(), 1 << 20);
  }
  /// The number `k` of row `i`.
  float number(std::size_t i, std::size_t k) const {
    const std::size_t begin = text.find("end_header\n") + 11, stride = (text.size() - begin) / 5;
    float value = 0.0F;
    std::memcpy(&value, text.data() + begin + i * stride + 4 * k, 4);
    return value;
  }
  TemporaryFile of, to{"", "drawn.ply"};
  std::string text;
};

TEST(DrawablePly, IsInriasLayoutAsItIs) {
  for (const int degree : {0, 1, 2, 3}) EXPECT_TRUE(draws(with_sh(degree).bytes())) << degree;
  PlyFile reordered = inria_file(3);
  std::reverse(reordered.properties.begin(), reordered.properties.end());
  EXPECT_TRUE(draws(reordered.bytes()));
  EXPECT_TRUE(is_drawable(TemporaryFile(std::string(64, '\1'), "scene.splat").path()));
}

/// Files that are read but not drawn, by what distinguishes them.
std::map<std::string, PlyFile> undrawn() {
  std::map<std::string, PlyFile> files;
  const PlyFile plain = inria_file(5);
  files["ASCII"] = files["big-endian"] = files["CR LF"] = files["double"] = files["element before"] = plain;
  files["element after"] = files["2DGS"] = files["no colour"] = files["Mip-Splatting"] =
      files["new type name"] = plain;
  files["ASCII"].encoding = Encoding::kAscii;
  files["big-endian"].encoding = Encoding::kBig;
  files["CR LF"].newline = "\r\n";
  for (PlyProperty& property : files["double"].properties) property.type = "double";
  for (PlyProperty& property : files["new type name"].properties) property.type = "float32";
  files["element before"].header_before = "element foo 1\nproperty list uchar char idx\n";
  files["element before"].data_before = {"\2\1\1"};
  files["element after"].header_after = "element foo 1\nproperty uchar a\n";
  files["element after"].data_after = "\7";
  files["2DGS"].remove("scale_2");
  for (const char* name : {"f_dc_0", "f_dc_1", "f_dc_2"}) files["no colour"].remove(name);
  files["SH of degree 4"] = with_sh(4);
  files["Mip-Splatting"].properties.push_back({"filter_3D"});
  return files;
}

TEST(DrawablePly, IsMadeOfEveryOtherFileWithTheGaussiansThatAreFelt) {
  for (const auto& [what, file] : undrawn()) {
    SCOPED_TRACE(what);
    EXPECT_FALSE(draws(file.bytes()));
    const Copy copy(file);
    EXPECT_TRUE(draws(copy.text));
    EXPECT_LE(copy.text.size(), drawable_ply_bytes(copy.of.path()));
    const GaussianScene felt = load_scene(copy.of.path()), drawn = load_scene(copy.to.path());
    ASSERT_EQ(drawn.size(), felt.size());
    EXPECT_TRUE(drawn.filter_3d.empty());
    for (std::size_t i = 0; i < felt.size(); ++i) {
      const Gaussian a = felt.gaussian(i), b = drawn.gaussian(i);
      EXPECT_LE((a.position - b.position).norm(), 1e-6);
      EXPECT_LE((a.sigma - b.sigma).norm(), 1e-6 * a.sigma.norm());
      EXPECT_NEAR(a.opacity, b.opacity, 1e-6);
      EXPECT_NEAR(std::abs(a.rotation.dot(b.rotation)), 1.0, 1e-12);
      if (!felt.color.empty()) {
        EXPECT_EQ(drawn.color[i], felt.color[i]);
      }
    }
  }
}

TEST(DrawablePly, KeepsTheColoursOfTheFile) {
  for (const int degree : {1, 3, 4}) {
    PlyFile file = with_sh(degree);
    file.encoding = Encoding::kBig;
    file.rows[2]["f_dc_1"] = 7.5;  // beyond what a byte can say
    const Copy copy(file);
    const int drawn = std::min(degree, 3), stored = (degree + 1) * (degree + 1) - 1;
    const int wanted = (drawn + 1) * (drawn + 1) - 1;
    EXPECT_EQ(copy.number(2, 4), 7.5F);
    for (int channel = 0; channel < 3; ++channel) {
      for (int k = 0; k < wanted; ++k) {
        const auto place = static_cast<std::size_t>(6 + channel * wanted + k);
        EXPECT_EQ(copy.number(3, place), static_cast<float>(0.01 * (channel * stored + k) + 3.0)) << degree;
      }
    }
  }
}

TEST(DrawablePly, IsNotMadeOfABrokenFile) {
  PlyFile file = inria_file(5);
  std::string bytes = file.bytes();
  bytes.resize(bytes.size() - 10);
  const TemporaryFile broken(bytes, "broken.ply");
  const TemporaryFile folder("", "x");
  const std::string to = (folder.folder() / "out.ply").string();
  EXPECT_THROW(write_drawable_ply(broken.path(), to), Error);
  EXPECT_FALSE(std::filesystem::exists(to));
}

}  // namespace
}  // namespace palpate::test

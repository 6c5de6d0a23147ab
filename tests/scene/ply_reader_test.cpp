// The .ply reader against files made byte by byte.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/scene/ply_reader.h>

#include "support/not_finite.h"
#include "support/ply_builder.h"
#include "support/temporary_file.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

GaussianScene read_bytes(const std::string& bytes) {
  const TemporaryFile file(bytes, "scene.ply");
  return read_ply(InputFile(file.path()));
}
GaussianScene read(const PlyFile& file) { return read_bytes(file.bytes()); }

/// The refusal of a file, which must name it.
std::string refusal(const std::string& bytes) {
  const TemporaryFile file(bytes, "scene.ply");
  const std::string message = message_of<Error>([&] { read_ply(InputFile(file.path())); });
  EXPECT_THAT(message, HasSubstr(file.path()));
  return message;
}
std::string refusal(const PlyFile& file) { return refusal(file.bytes()); }

/// What the scene holds of Gaussian `i`, by property name.
PlyRow row_of(const GaussianScene& scene, std::size_t i) {
  const Eigen::Vector3d p = scene.gaussian(i).position;
  return {{"x", p.x()},
          {"y", p.y()},
          {"z", p.z()},
          {"opacity", scene.opacity[i]},
          {"scale_0", scene.scale[i][0]},
          {"scale_1", scene.scale[i][1]},
          {"scale_2", scene.scale[i][2]},
          {"rot_0", scene.rotation[i][0]},
          {"rot_1", scene.rotation[i][1]},
          {"rot_2", scene.rotation[i][2]},
          {"rot_3", scene.rotation[i][3]}};
}

void expect_row(const GaussianScene& scene, std::size_t i, const PlyRow& expected) {
  for (const auto& [name, value] : row_of(scene, i))
    EXPECT_EQ(value, expected.at(name)) << name << " of " << i;
}

TEST(PlyReader, ReadsTheLayoutThatInriaTrains) {
  const PlyFile file = inria_file(3);
  const GaussianScene scene = read(file);
  ASSERT_EQ(scene.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    expect_row(scene, i, file.rows[i]);
    EXPECT_EQ(scene.id[i], i);
  }
  EXPECT_EQ(scene.trailing_bytes, 0U);
  EXPECT_EQ(scene.sh_degree, 0);
  EXPECT_EQ(scene.origin, Eigen::Vector3d::Zero());
  EXPECT_EQ(scene.scale_encoding, ScaleEncoding::kLog);
  EXPECT_EQ(scene.opacity_encoding, OpacityEncoding::kLogit);
  EXPECT_TRUE(scene.filter_3d.empty());
  // 255 (0.5 + 0.28209 f_dc), rounded, for f_dc = 0.5, -0.5, 1
  EXPECT_EQ(scene.color[0], (std::array<std::uint8_t, 3>{163, 92, 199}));
}

TEST(PlyReader, ReadsAHeaderThatEndsAnywhereInItsBuffers) {
  PlyFile file = inria_file(1);
  const std::size_t rest = file.header().size() + std::string("comment \n").size();
  for (std::size_t bytes = 16384 - 2; bytes <= 16384 + 14; ++bytes) {
    file.header_before = "comment " + std::string(bytes - rest, 'a') + "\n";
    ASSERT_EQ(file.header().size(), bytes);
    EXPECT_EQ(read(file).size(), 1U) << bytes;
  }
}

TEST(PlyReader, TakesPropertiesInAnyOrderBetweenOthersOfAnyType) {
  std::mt19937 random(1);
  const char* const types[] = {"char", "ushort", "int32", "float64", "uint8", "double"};
  for (int round = 0; round < 60; ++round) {
    PlyFile file = inria_file(2);
    file.encoding = kEncodings[round % 3];
    for (int k = 0; k < 6; ++k) file.properties.push_back({"extra_" + std::to_string(k), types[k]});
    for (PlyRow& row : file.rows)
      for (int k = 0; k < 6; ++k) row["extra_" + std::to_string(k)] = 40 + k;
    std::shuffle(file.properties.begin(), file.properties.end(), random);
    const GaussianScene scene = read(file);
    for (std::size_t i = 0; i < 2; ++i) expect_row(scene, i, file.rows[i]);
    EXPECT_EQ(scene.color[1], (std::array<std::uint8_t, 3>{163, 92, 199}));
    EXPECT_EQ(scene.trailing_bytes, 0U);
  }
}

TEST(PlyReader, TakesEveryNumericTypeForEveryProperty) {
  // Values that only the right width and signedness give back; exact in single precision.
  const std::pair<const char*, double> types[] = {
      {"char", -100},    {"int8", -100},     {"uchar", 200},       {"uint8", 200},
      {"short", -30000}, {"int16", -30000},  {"ushort", 50000},    {"uint16", 50000},
      {"int", -2e9},     {"int32", -2e9},    {"uint", 4e9},        {"uint32", 4e9},
      {"float", -0.375}, {"float32", 1e-3F}, {"double", 0.078125}, {"float64", -123.5}};
  for (const Encoding encoding : kEncodings) {
    for (const auto& [type, value] : types) {
      for (const PlyProperty& property : bare_properties()) {
        SCOPED_TRACE(std::string(type) + " " + property.name);
        PlyFile file = inria_file(2);
        file.encoding = encoding;
        file.property(property.name).type = type;
        file.rows[0][property.name] = value;
        file.rows[1][property.name] = 17;
        const GaussianScene scene = read(file);
        expect_row(scene, 0, file.rows[0]);
        expect_row(scene, 1, file.rows[1]);
      }
    }
  }
}

TEST(PlyReader, RoundsDoublesToSinglePrecisionButNotPositions) {
  PlyFile file = inria_file(1);
  for (PlyProperty& p : file.properties) p.type = "double";
  file.rows[0]["x"] = 0.1;
  file.rows[0]["scale_0"] = -0.3;
  file.rows[0]["rot_2"] = 1e-300;
  const GaussianScene scene = read(file);
  EXPECT_NEAR(scene.gaussian(0).position.x(), 0.1, 1e-8);
  EXPECT_EQ(scene.scale[0][0], -0.3F);
  EXPECT_EQ(scene.rotation[0][2], 0.0F);
}

// --- ASCII ------------------------------------------------------------------------------------

/// A file of one Gaussian whose data are `data`, in the order of bare_properties().
std::string ascii_with(const std::string& data, int count = 1) {
  PlyFile file;
  file.encoding = Encoding::kAscii;
  file.properties = bare_properties();
  file.rows.resize(static_cast<std::size_t>(count));
  return file.header() + data;
}

TEST(PlyReader, TakesTheNumberFormsOfAscii) {
  const GaussianScene scene =
      read_bytes(ascii_with(" \t+1.5  -2.5e0\t.5 1e999 -1e999 1e-999 -inf nan +inf 1 0 \r\n"));
  EXPECT_EQ(scene.position[0], Eigen::Vector3f(1.5F, -2.5F, 0.5F));
  EXPECT_EQ(scene.opacity[0], kInfinity);
  EXPECT_EQ(scene.scale[0], Eigen::Vector3f(-kInfinity, 0.0F, -kInfinity));
  EXPECT_TRUE(std::isnan(scene.rotation[0][0]));
  EXPECT_EQ(scene.rotation[0][1], kInfinity);
}

TEST(PlyReader, SkipsBlankLinesAndEndsWithoutANewline) {
  const std::string row = "1 2 3 4 5 6 7 8 9 10 11";
  for (const std::string& data : {"\n\r\n \t\n" + row + "\r\n\n\n" + row, row + "\r\n" + row + "\r\n\r\n"}) {
    const GaussianScene scene = read_bytes(ascii_with(data, 2));
    ASSERT_EQ(scene.size(), 2U);
    EXPECT_EQ(scene.position[1], Eigen::Vector3f(1, 2, 3));
    EXPECT_EQ(scene.rotation[1], Eigen::Vector4f(8, 9, 10, 11));
  }
}

TEST(PlyReader, RefusesAsciiRowsThatAreNotThatManyNumbers) {
  EXPECT_THAT(refusal(ascii_with("1 2 3 4 5 6 7 8 9 10\n\n\n")), HasSubstr("'rot_3'"));
  EXPECT_THAT(refusal(ascii_with("1 2 3 4 5 6 7 8 9 10 11 12\n")), HasSubstr("more than 11 values"));
  EXPECT_THAT(refusal(ascii_with("1 2 three 4 5 6 7 8 9 10 11\n")), HasSubstr("'z'"));
  for (const char* word : {"0x10", "1,5", "1.5f", "--1", "+-1", "1e", "nan(", "\"1\"", "1\xc2\xa0"}) {
    SCOPED_TRACE(word);
    EXPECT_THAT(refusal(ascii_with(std::string("1 ") + word + " 3 4 5 6 7 8 9 10 11\n")), HasSubstr("'y'"));
  }
  EXPECT_THAT(refusal(ascii_with(std::string("1 2\0 3 4 5 6 7 8 9 10 11\n", 26))), HasSubstr("'y'"));
}

TEST(PlyReader, RefusesAsciiIntegersOutOfTheRangeOfTheirType) {
  for (const auto& [type, bad] : {std::pair{"uchar", "256"},
                                  {"uchar", "-1"},
                                  {"char", "128"},
                                  {"short", "32768"},
                                  {"int", "2147483648"},
                                  {"uint", "-1"},
                                  {"int", "1.5"},
                                  {"int", "nan"},
                                  {"uint", "1e999"}}) {
    SCOPED_TRACE(std::string(type) + " " + bad);
    PlyFile file;
    file.encoding = Encoding::kAscii;
    file.properties = bare_properties();
    file.property("y").type = type;
    file.rows.resize(1);
    EXPECT_THAT(refusal(file.header() + "1 " + bad + " 3 4 5 6 7 8 9 10 11\n"), HasSubstr("'y'"));
  }
}

TEST(PlyReader, NamesTheByteOfABrokenAsciiRow) {
  const std::string good = "1 2 3 4 5 6 7 8 9 10 11\n";
  const std::string start = ascii_with("", 2) + good;
  EXPECT_THAT(refusal(start + "1 2 3 4 5 6 7 8 9 10 x\n"),
              HasSubstr("byte " + std::to_string(start.size()) + ":"));
}

TEST(PlyReader, FindsRowsAcrossItsReadBuffers) {
  PlyFile file = inria_file(0);
  file.encoding = Encoding::kAscii;
  for (int k = 0; k < 30000; ++k) file.rows.push_back(distinct_row(k));  // 2.4 MB
  const GaussianScene scene = read(file);
  ASSERT_EQ(scene.size(), 30000U);
  for (std::size_t k = 0; k < 30000; ++k) ASSERT_EQ(scene.position[k].x(), 1.5F + static_cast<float>(k));
}

TEST(PlyReader, FindsBinaryRowsAcrossItsReadBuffers) {
  constexpr std::size_t kCount = 130000;  // 8.8 MB
  PlyFile file = inria_file(1);
  const std::string row = file.data();
  file.rows.resize(kCount);
  std::string bytes = file.header();
  for (std::size_t k = 0; k < kCount; ++k) {
    bytes += number_bytes("float", static_cast<double>(k), Encoding::kLittle);
    bytes.append(row, 4);
  }
  const GaussianScene scene = read_bytes(bytes);
  ASSERT_EQ(scene.size(), kCount);
  for (std::size_t k = 0; k < kCount; ++k) {
    ASSERT_EQ(scene.position[k].x(), static_cast<float>(k));
    ASSERT_EQ(scene.rotation[k][3], 2.0F);
  }
}

// --- header -----------------------------------------------------------------------------------

TEST(PlyReader, SkipsCommentsAndObjInfoAnywhereInTheHeader) {
  const PlyFile file = inria_file(2);
  const std::string header = file.header();
  std::string commented;
  std::size_t line = 0;
  for (const char c : header) {
    commented += c;
    if (c == '\n' && commented.size() < header.size() + 1000 && !commented.ends_with("end_header\n"))
      commented += ++line % 2 ? "comment element vertex 7\n" : "obj_info end_header\n";
  }
  const GaussianScene scene = read_bytes(commented + file.data());
  ASSERT_EQ(scene.size(), 2U);
  expect_row(scene, 1, file.rows[1]);
}

TEST(PlyReader, TakesDataThatBeginWithNewlinesForData) {
  for (const std::string newline : {"\n", "\r\n"}) {
    for (const std::string start : {"\n\n\n\n", "\r\n\r\n", "\n\r\n\r", "\r\r\n\n"}) {
      PlyFile file = inria_file(2);
      file.newline = newline;
      std::string data = file.data();
      data.replace(0, 4, start);
      float x = 0.0F;
      std::memcpy(&x, start.data(), 4);
      const GaussianScene scene = read_bytes(file.header() + data);
      EXPECT_EQ(scene.position[0].x(), x);
      EXPECT_EQ(scene.position[1].x(), 2.5F);
      EXPECT_EQ(scene.trailing_bytes, 0U);
    }
  }
}

TEST(PlyReader, TakesCrLfInHeaderAndAsciiRows) {
  for (const Encoding encoding : kEncodings) {
    PlyFile file = inria_file(3);
    file.encoding = encoding;
    file.newline = "\r\n";
    const GaussianScene scene = read(file);
    ASSERT_EQ(scene.size(), 3U);
    expect_row(scene, 2, file.rows[2]);
  }
}

TEST(PlyReader, RefusesHeadersThatContradictThemselves) {
  const auto with = [](const std::string& header) { return refusal("ply\n" + header + "end_header\n"); };
  const std::string format = "format ascii 1.0\n";
  EXPECT_THAT(with("element vertex 1\n"), HasSubstr("without a format"));
  EXPECT_THAT(with(format + format), HasSubstr("second format"));
  EXPECT_THAT(with("format ascii 2.0\n"), HasSubstr("line 2"));
  EXPECT_THAT(with("format utf8 1.0\n"), HasSubstr("utf8"));
  EXPECT_THAT(with("format ascii\n"), HasSubstr("line 2"));
  EXPECT_THAT(with(format + "property float x\n"), HasSubstr("before the first element"));
  EXPECT_THAT(with(format + "element vertex\n"), HasSubstr("line 3"));
  EXPECT_THAT(with(format + "element vertex 1\nelement vertex 1\n"), HasSubstr("line 4"));
  EXPECT_THAT(with(format + "element vertex 1\nproperty float x\nproperty float x\n"), HasSubstr("'x'"));
  EXPECT_THAT(with(format + "element vertex 1\nproperty half x\n"), HasSubstr("'half'"));
  EXPECT_THAT(with(format + "element vertex 1\nproperty float\n"), HasSubstr("line 4"));
  EXPECT_THAT(with(format + "element vertex 1\nproperty list uchar x\n"), HasSubstr("line 4"));
  EXPECT_THAT(with(format + "elephant vertex 1\n"), HasSubstr("'elephant'"));
  EXPECT_THAT(refusal("ply\n" + format), HasSubstr("without end_header"));
  EXPECT_THAT(refusal("ply\n" + format + "comment " + std::string(2 << 20, 'c')), HasSubstr("end_header"));
}

TEST(PlyReader, RefusesCountsThatAreLies) {
  for (const char* count : {"-1", "0", "1e3", "3", "0x2", "+2", "4294967297", "1000000000000000000",
                            "18446744073709551615", "18446744073709551616", "99999999999999999999999"}) {
    for (const Encoding encoding : kEncodings) {
      SCOPED_TRACE(count);
      PlyFile file = inria_file(2);
      file.encoding = encoding;
      std::string bytes = file.bytes();
      bytes.replace(bytes.find("vertex 2") + 7, 1, count);
      refusal(bytes);
    }
  }
}

TEST(PlyReader, RefusesAFileWithoutGaussians) {
  const auto without = [](const char* name) {
    PlyFile file = inria_file(1);
    file.remove(name);
    return refusal(file);
  };
  for (const char* name :
       {"x", "y", "z", "opacity", "scale_0", "scale_1", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    EXPECT_THAT(without(name), HasSubstr("'" + std::string(name) + "'"));
  }
  for (const char* name : {"f_dc_0", "f_dc_1", "f_dc_2"}) EXPECT_THAT(without(name), HasSubstr("f_dc_"));
  EXPECT_THAT(refusal("ply\nformat ascii 1.0\nelement face 1\nproperty float x\nend_header\n1\n"),
              HasSubstr("'vertex'"));
}

TEST(PlyReader, RefusesListsInTheVertexElement) {
  for (const Encoding encoding : kEncodings) {
    PlyFile file = inria_file(1);
    file.encoding = encoding;
    std::string bytes = file.bytes();
    const std::string property = "property float rot_1";
    bytes.replace(bytes.find(property), property.size(), "property list uchar float rot_1");
    EXPECT_THAT(refusal(bytes), HasSubstr("'rot_1' is a list"));
  }
}

// --- variants ---------------------------------------------------------------------------------

TEST(PlyReader, DoesWithoutNormalsAndColour) {
  PlyFile file = inria_file(2);
  file.properties = bare_properties();
  const GaussianScene scene = read(file);
  expect_row(scene, 1, file.rows[1]);
  EXPECT_TRUE(scene.color.empty());
}

TEST(PlyReader, ClampsColours) {
  PlyFile file = inria_file(1);
  file.rows[0]["f_dc_0"] = 1e30;
  file.rows[0]["f_dc_1"] = -kInfinity;
  file.rows[0]["f_dc_2"] = kNan;
  EXPECT_EQ(read(file).color[0], (std::array<std::uint8_t, 3>{255, 0, 0}));
}

TEST(PlyReader, CountsTheSphericalHarmonics) {
  const int counts[] = {0, 9, 24, 45, 72};
  for (int degree = 0; degree <= 4; ++degree) {
    PlyFile file = inria_file(2);
    for (int k = 0; k < counts[degree]; ++k) file.properties.push_back({"f_rest_" + std::to_string(k)});
    std::rotate(file.properties.begin(), file.properties.begin() + 9, file.properties.end());
    const GaussianScene scene = read(file);
    EXPECT_EQ(scene.sh_degree, degree);
    expect_row(scene, 1, file.rows[1]);
  }
}

TEST(PlyReader, RefusesSphericalHarmonicsOfNoDegree) {
  for (const int count : {1, 8, 10, 44, 46, 105}) {
    PlyFile file = inria_file(1);
    for (int k = 0; k < count; ++k) file.properties.push_back({"f_rest_" + std::to_string(k)});
    EXPECT_THAT(refusal(file), HasSubstr(std::to_string(count) + " properties f_rest_"));
  }
  PlyFile gap = inria_file(1);
  for (int k = 0; k < 9; ++k) gap.properties.push_back({"f_rest_" + std::to_string(k == 4 ? 9 : k)});
  EXPECT_THAT(refusal(gap), HasSubstr("'f_rest_4'"));
}

TEST(PlyReader, TakesA2dgsDiscForExactlyFlat) {
  for (const Encoding encoding : kEncodings) {
    PlyFile file = inria_file(2);
    file.encoding = encoding;
    file.remove("scale_2");
    const GaussianScene scene = read(file);
    for (std::size_t i = 0; i < 2; ++i) {
      const Gaussian g = scene.gaussian(i);
      EXPECT_EQ(g.sigma.z(), 0.0);
      EXPECT_DOUBLE_EQ(g.sigma.x(), std::exp(-1.5));
      EXPECT_EQ(defect(scene, i), Defect::kNone);
    }
    EXPECT_THAT(scene.format, HasSubstr("2DGS"));
  }
}

TEST(PlyReader, AppliesTheFilterOfMipSplatting) {
  PlyFile file = inria_file(1);
  file.properties.push_back({"filter_3D"});
  file.rows[0]["scale_0"] = std::log(0.3);
  file.rows[0]["scale_1"] = std::log(0.5);
  file.rows[0]["scale_2"] = std::log(1.2);
  file.rows[0]["filter_3D"] = 0.4;
  file.rows[0]["opacity"] = 0.0;  // alpha = 1/2
  const GaussianScene scene = read(file);
  const Gaussian g = scene.gaussian(0);
  // sqrt(s^2 + 0.4^2) by hand; alpha' = 1/2 * 0.3/0.5 * 0.5/0.640312 * 1.2/1.264911
  EXPECT_NEAR(g.sigma.x(), 0.5, 1e-7);
  EXPECT_NEAR(g.sigma.y(), 0.64031242374, 1e-7);
  EXPECT_NEAR(g.sigma.z(), 1.26491106407, 1e-7);
  EXPECT_NEAR(g.opacity, 0.5 * 0.6 * 0.78086880944 * 0.94868329805, 1e-7);
  EXPECT_THAT(scene.format, HasSubstr("Mip-Splatting"));
}

TEST(PlyReader, KeepsWhatOnlyActivationMakesFinite) {
  PlyFile file = inria_file(3);
  file.rows[0]["opacity"] = kInfinity;
  file.rows[1]["opacity"] = -kInfinity;
  file.rows[2]["scale_1"] = -kInfinity;
  const GaussianScene scene = read(file);
  EXPECT_EQ(scene.gaussian(0).opacity, 1.0);
  EXPECT_EQ(scene.gaussian(1).opacity, 0.0);
  EXPECT_EQ(scene.gaussian(2).sigma.y(), 0.0);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(defect(scene, i), Defect::kNone);
}

TEST(PlyReader, NormalisesQuaternionsWhenActivating) {
  PlyFile file = inria_file(2);
  const double tiny = 1e-30, huge = 1e30;
  file.rows[0]["rot_0"] = file.rows[0]["rot_1"] = file.rows[0]["rot_2"] = file.rows[0]["rot_3"] = -tiny;
  file.rows[1]["rot_0"] = file.rows[1]["rot_1"] = file.rows[1]["rot_2"] = file.rows[1]["rot_3"] = huge;
  const GaussianScene scene = read(file);
  EXPECT_LT((scene.gaussian(0).rotation.coeffs() - Eigen::Vector4d::Constant(-0.5)).norm(), 1e-15);
  EXPECT_LT((scene.gaussian(1).rotation.coeffs() - Eigen::Vector4d::Constant(0.5)).norm(), 1e-15);
}

TEST(PlyReader, KeepsRowsWithDefectsSoThatIdsAreRows) {
  PlyFile file = inria_file(3);
  file.rows[0]["x"] = kNan;
  file.rows[1]["rot_0"] = file.rows[1]["rot_1"] = file.rows[1]["rot_2"] = file.rows[1]["rot_3"] = 0.0;
  const GaussianScene scene = read(file);
  ASSERT_EQ(scene.size(), 3U);
  EXPECT_EQ(defect(scene, 0), Defect::kNan);
  EXPECT_EQ(defect(scene, 1), Defect::kZeroQuaternion);
  EXPECT_EQ(scene.id[2], 2U);
}

// --- where data begin and end -----------------------------------------------------------------

TEST(PlyReader, CountsTrailingBytes) {
  for (const std::string extra : {"x", "1234567", "\n\n"}) {
    PlyFile file = inria_file(2);
    file.data_after = extra;
    EXPECT_EQ(read(file).trailing_bytes, extra.size());
  }
}

/// Elements before and behind `vertex`, some with lists, with their data.
PlyFile among_others(Encoding encoding) {
  PlyFile file = inria_file(2);
  file.encoding = encoding;
  const auto number = [&](const char* type, double v) { return number_bytes(type, v, encoding); };
  const std::string end = encoding == Encoding::kAscii ? "\n" : "";
  file.header_before =
      "element camera 2\nproperty double f\nproperty uchar kind\n"
      "element face 3\nproperty list uchar int vertex_indices\nproperty list ushort double weights\n"
      "element nothing 0\nproperty list int int i\nelement void 0\n";
  for (int k = 0; k < 2; ++k) file.data_before += number("double", 0.5) + number("uchar", k) + end;
  for (int k = 0; k < 3; ++k) {
    file.data_before += number("uchar", k);
    for (int i = 0; i < k; ++i) file.data_before += number("int", i);
    file.data_before += number("ushort", 1) + number("double", 0.25) + end;
  }
  file.header_after = "element edge 2\nproperty list char float l\nproperty short s\n";
  for (int k = 0; k < 2; ++k) {
    file.data_after += number("char", 3);
    for (int i = 0; i < 3; ++i) file.data_after += number("float", i);
    file.data_after += number("short", -7) + end;
  }
  return file;
}

TEST(PlyReader, SkipsElementsBeforeAndBehind) {
  for (const Encoding encoding : kEncodings) {
    SCOPED_TRACE(static_cast<int>(encoding));
    const PlyFile file = among_others(encoding);
    const GaussianScene scene = read(file);
    ASSERT_EQ(scene.size(), 2U);
    expect_row(scene, 0, file.rows[0]);
    expect_row(scene, 1, file.rows[1]);
    EXPECT_EQ(scene.trailing_bytes, 0U);
  }
}

TEST(PlyReader, RefusesABinaryFileCutAnywhere) {
  for (const Encoding encoding : {Encoding::kLittle, Encoding::kBig}) {
    const PlyFile file = among_others(encoding);
    const std::string bytes = file.bytes();
    const std::size_t header = file.header().size();
    for (std::size_t length = 4; length < bytes.size(); length += length < header - 20 ? 13 : 1) {
      SCOPED_TRACE(length);
      refusal(bytes.substr(0, length));
    }
  }
}

TEST(PlyReader, RefusesAnAsciiFileCutAtAnyLine) {
  const std::string bytes = among_others(Encoding::kAscii).bytes();
  for (std::size_t length = bytes.find('\n') + 1; length < bytes.size();
       length = bytes.find('\n', length) + 1) {
    SCOPED_TRACE(length);
    refusal(bytes.substr(0, length));
  }
}

TEST(PlyReader, RefusesListsOfImpossibleLength) {
  for (const double items : {-1.0, 2e9}) {
    PlyFile file = inria_file(1);
    file.header_before = "element face 1\nproperty list int double l\n";
    file.data_before = number_bytes("int", items, Encoding::kLittle);
    EXPECT_THAT(refusal(file), HasSubstr("'l'"));
  }
}

// --- double-precision positions ---------------------------------------------------------------

PlyFile with_positions(const std::vector<Eigen::Vector3d>& positions) {
  PlyFile file;
  file.properties = bare_properties();
  for (const char* axis : {"x", "y", "z"}) file.property(axis).type = "double";
  for (const Eigen::Vector3d& p : positions) {
    PlyRow row = distinct_row();
    row["x"] = p.x();
    row["y"] = p.y();
    row["z"] = p.z();
    file.rows.push_back(row);
  }
  return file;
}

/// Largest error allowed for a coordinate: the float spacing at its distance from the origin.
double float_ulp(double offset) {
  const float a = static_cast<float>(std::abs(offset));
  return std::nextafter(a, kFloatInfinity) - a;
}

TEST(PlyReader, KeepsGeoreferencedPositionsToAFloatOfTheirOffset) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> offset(-50.0, 50.0);
  std::vector<Eigen::Vector3d> positions;
  for (int k = 0; k < 200; ++k)
    positions.push_back({500000.123 + offset(random), 5.4e6 + offset(random), 312.7 + 0.1 * offset(random)});
  const GaussianScene scene = read(with_positions(positions));
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Eigen::Vector3d error = scene.gaussian(i).position - positions[i];
    for (int axis = 0; axis < 3; ++axis)
      ASSERT_LE(std::abs(error[axis]), float_ulp(positions[i][axis] - scene.origin[axis])) << i;
    ASSERT_LT(error.cwiseAbs().maxCoeff(), 1e-5) << i;
  }
}

TEST(PlyReader, LeavesPositionsThatFloatHoldsAlone) {
  const GaussianScene scene = read(with_positions({{1.5, -2.25, 1e6}, {0.0, kInfinity, 3.0}, {kNan, 0, 0}}));
  EXPECT_EQ(scene.origin, Eigen::Vector3d::Zero());
  EXPECT_EQ(scene.position[0], Eigen::Vector3f(1.5F, -2.25F, 1e6F));
  EXPECT_EQ(defect(scene, 1), Defect::kInfinite);
  EXPECT_EQ(defect(scene, 2), Defect::kNan);
}

TEST(PlyReader, IsNotThrownOffByAStrayPositionInDoublePrecision) {
  // One stray Gaussian, wherever it stands in the file, must not cost the others their digits.
  for (const double stray : {1e7, -3e9, 1e30, 1e300, kInfinity, kNan}) {
    for (const std::size_t at : {std::size_t{0}, std::size_t{2}, std::size_t{4}}) {
      SCOPED_TRACE(fmt::format("{} at row {}", stray, at));
      std::vector<Eigen::Vector3d> positions{
          {0.1, 0.2, 0.3}, {0.11, 0.21, 0.31}, {0.12, 0.22, 0.32}, {0.13, 0.23, 0.33}};
      positions.insert(positions.begin() + static_cast<std::ptrdiff_t>(at), Eigen::Vector3d(stray, 0.1, 0.1));
      const GaussianScene scene = read(with_positions(positions));
      for (std::size_t i = 0; i < positions.size(); ++i) {
        if (i == at) continue;
        EXPECT_EQ(defect(scene, i), Defect::kNone);
        EXPECT_LT((scene.gaussian(i).position - positions[i]).norm(), 1e-6);
      }
    }
  }
}

TEST(PlyReader, CallsADoubleThatIsTooLargeADefect) {
  const GaussianScene scene = read(with_positions({{0.1, 0, 0}, {1e30, 0, 0}, {1e300, 0, 0}}));
  EXPECT_EQ(defect(scene, 0), Defect::kNone);
  EXPECT_EQ(defect(scene, 1), Defect::kInfinite);
  EXPECT_EQ(defect(scene, 2), Defect::kInfinite);
}

}  // namespace
}  // namespace palpate::test

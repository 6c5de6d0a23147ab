/// \file
/// .ply files made byte by byte, independently of the reader and the writer under test.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace palpate::test {

enum class Encoding { kAscii, kLittle, kBig };
inline constexpr Encoding kEncodings[] = {Encoding::kAscii, Encoding::kLittle, Encoding::kBig};

/// The bytes of `value` as a T, lowest first or highest first.
template <typename T>
std::string bytes_as(double value, bool big) {
  const T number = static_cast<T>(value);
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &number, sizeof(T));  // the tests run on little-endian machines
  if (big) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// One number of a .ply type (old or new name), as the file has it.
inline std::string number_bytes(const std::string& type, double value, Encoding encoding) {
  const bool big = encoding == Encoding::kBig;
  if (encoding == Encoding::kAscii) return fmt::format("{} ", value);
  if (type == "char" || type == "int8") return bytes_as<std::int8_t>(value, big);
  if (type == "uchar" || type == "uint8") return bytes_as<std::uint8_t>(value, big);
  if (type == "short" || type == "int16") return bytes_as<std::int16_t>(value, big);
  if (type == "ushort" || type == "uint16") return bytes_as<std::uint16_t>(value, big);
  if (type == "int" || type == "int32") return bytes_as<std::int32_t>(value, big);
  if (type == "uint" || type == "uint32") return bytes_as<std::uint32_t>(value, big);
  if (type == "float" || type == "float32") return bytes_as<float>(value, big);
  return bytes_as<double>(value, big);
}

/// Numbers of one row by property name; a name that is not there stands for 0.
using PlyRow = std::map<std::string, double>;

struct PlyProperty {
  std::string name;
  std::string type = "float";
};

/// A .ply file with an element `vertex`, whose every part a test may change.
struct PlyFile {
  Encoding encoding = Encoding::kLittle;
  std::string newline = "\n";  ///< of the header, and of ASCII rows
  std::vector<PlyProperty> properties;
  std::vector<PlyRow> rows;
  std::string header_before, data_before;  ///< elements in front of `vertex`: header lines and raw data
  std::string header_after, data_after;    ///< and behind it

  std::string format_name() const {
    return encoding == Encoding::kAscii    ? "ascii"
           : encoding == Encoding::kLittle ? "binary_little_endian"
                                           : "binary_big_endian";
  }

  std::string header() const {
    std::string text = "ply\nformat " + format_name() + " 1.0\n" + header_before;
    text += fmt::format("element vertex {}\n", rows.size());
    for (const PlyProperty& p : properties) text += "property " + p.type + " " + p.name + "\n";
    text += header_after + "end_header\n";
    std::string out;
    for (const char c : text) out += c == '\n' ? newline : std::string(1, c);
    return out;
  }

  std::string data() const {
    std::string out;
    for (const PlyRow& row : rows) {
      for (const PlyProperty& p : properties) {
        const auto found = row.find(p.name);
        out += number_bytes(p.type, found == row.end() ? 0.0 : found->second, encoding);
      }
      if (encoding == Encoding::kAscii) out += newline;
    }
    return out;
  }

  std::string bytes() const { return header() + data_before + data() + data_after; }

  PlyProperty& property(const std::string& name) {
    return *std::find_if(properties.begin(), properties.end(), [&](const auto& p) { return p.name == name; });
  }
  void remove(const std::string& name) {
    std::erase_if(properties, [&](const PlyProperty& p) { return p.name == name; });
  }
};

inline std::vector<PlyProperty> named(std::initializer_list<const char*> names) {
  std::vector<PlyProperty> properties;
  for (const char* name : names) properties.push_back({name});
  return properties;
}

/// Only what a Gaussian cannot do without.
inline std::vector<PlyProperty> bare_properties() {
  return named(
      {"x", "y", "z", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"});
}

/// INRIA's layout at SH degree 0.
inline std::vector<PlyProperty> inria_properties() {
  return named({"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0",
                "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"});
}

/// A row whose values are all different and exact in single precision; `k` makes rows differ.
inline PlyRow distinct_row(int k = 0) {
  return {{"x", 1.5 + k},    {"y", -2.25},      {"z", 3.125},       {"opacity", 0.75}, {"scale_0", -1.5},
          {"scale_1", -2.5}, {"scale_2", -3.5}, {"rot_0", 0.5},     {"rot_1", -0.25},  {"rot_2", 0.125},
          {"rot_3", 2.0},    {"f_dc_0", 0.5},   {"f_dc_1", -0.5},   {"f_dc_2", 1.0},   {"nx", 9.0},
          {"ny", 10.0},      {"nz", 11.0},      {"filter_3D", 0.25}};
}

/// `count` distinct rows in INRIA's layout.
inline PlyFile inria_file(int count = 2) {
  PlyFile file;
  file.properties = inria_properties();
  for (int k = 0; k < count; ++k) file.rows.push_back(distinct_row(k));
  return file;
}

}  // namespace palpate::test

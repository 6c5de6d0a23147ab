/// \file
/// Header of a Stanford .ply file: its elements, properties and encoding.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/base/file.h>
#include <palpate/scene/bytes.h>

namespace palpate {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

/// Calls use(T{}) for the C++ type T that `type` names.
template <typename Use>
auto with_type(PlyType type, const Use& use) {
  switch (type) {
    case PlyType::kInt8: return use(std::int8_t{});
    case PlyType::kUint8: return use(std::uint8_t{});
    case PlyType::kInt16: return use(std::int16_t{});
    case PlyType::kUint16: return use(std::uint16_t{});
    case PlyType::kInt32: return use(std::int32_t{});
    case PlyType::kUint32: return use(std::uint32_t{});
    case PlyType::kFloat32: return use(float{});
    case PlyType::kFloat64: break;
  }
  return use(double{});
}

/// Bytes of one number.
std::size_t size_of(PlyType type);
/// The number stored at `bytes`, exactly: every .ply type fits a double.
double load_number(const char* bytes, PlyType type, ByteOrder order);
/// True if `type` can represent an ASCII number (integers must be integers in range).
bool holds(PlyType type, double value);
const char* to_string(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type;                        ///< of the value, or of a list's items
  std::optional<PlyType> list_length;  ///< type of the item count, if the property is a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count;
  std::vector<PlyProperty> properties;

  /// Bytes of one row in a binary file; nothing if a list makes the row size vary.
  std::optional<std::size_t> stride() const;
  /// Index of the property named `name`, if present.
  std::optional<std::size_t> find(std::string_view name) const;
};

enum class PlyEncoding { kAscii, kBinaryLittleEndian, kBinaryBigEndian };
const char* to_string(PlyEncoding encoding);

struct PlyHeader {
  PlyEncoding encoding;
  std::vector<PlyElement> elements;  ///< in the order of their data
  std::uint64_t data_offset;         ///< byte after the line "end_header"
};

/// True if a file with these first bytes (at least 4, if it has them) claims to be a .ply.
bool is_ply(std::string_view start);

/// Reads the header: comments and obj_info are skipped, lines end in LF or CR LF. \throws Error naming the
/// line if the header is malformed, contradicts itself, or does not end within 1 MiB.
PlyHeader read_ply_header(const InputFile& file);

}  // namespace palpate

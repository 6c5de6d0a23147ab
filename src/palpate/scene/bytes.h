/// \file
/// Decoding of numbers from raw bytes, in either byte order and without alignment.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

namespace palpate {

enum class ByteOrder { kLittle, kBig };

/// The T stored at `bytes` (sizeof(T) bytes, any alignment) in byte order `order`.
template <typename T>
T load_as(const char* bytes, ByteOrder order) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes, sizeof(T));
  constexpr bool kNativeIsLittle = std::endian::native == std::endian::little;
  if ((order == ByteOrder::kLittle) != kNativeIsLittle) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

}  // namespace palpate

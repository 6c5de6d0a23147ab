/// \file
/// Parallel reader of fixed-size rows of a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include <tbb/enumerable_thread_specific.h>

#include <palpate/base/file.h>

namespace palpate {

/// Consecutive rows in memory.
struct RowBlock {
  const char* bytes;
  std::size_t stride;  ///< bytes of a row
  std::size_t count;   ///< rows

  const char* row(std::size_t k) const { return bytes + k * stride; }
};

/// Reads rows of `stride` bytes that begin at byte `offset` of a file, in blocks that stay in the cache of
/// the processor that decodes them.
class RowReader {
 public:
  /// Decodes a block whose first row has index `at` among the requested ones.
  using Decode = std::function<void(const RowBlock& block, std::size_t at)>;

  /// \param file held by reference. \pre stride > 0.
  RowReader(const InputFile& file, std::uint64_t offset, std::size_t stride);

  /// Calls `decode` once for each block of the rows first ... first + n - 1, from several threads. \throws
  /// Error when the read fails; whatever `decode` throws.
  void read(std::uint64_t first, std::size_t n, const Decode& decode);

 private:
  const InputFile& file_;
  std::uint64_t offset_;
  std::size_t stride_;
  tbb::enumerable_thread_specific<std::vector<char>> buffers_;
};

}  // namespace palpate

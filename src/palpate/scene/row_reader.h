/// \file
/// Rows of one size out of a file, read and decoded by all processors.
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

/// Reads rows of `stride` bytes that begin at byte `offset` of a file. The rows are read in blocks that
/// stay in the cache of the processor that decodes them.
class RowReader {
 public:
  /// Takes a block whose first row is number `at` of those asked for.
  using Decode = std::function<void(const RowBlock& block, std::size_t at)>;

  /// \param file is kept by reference. \pre stride > 0.
  RowReader(const InputFile& file, std::uint64_t offset, std::size_t stride);

  /// Calls `decode` with every part of the rows first ... first + n - 1 once, from several threads.
  /// \throws Error when the read fails; whatever `decode` throws.
  void read(std::uint64_t first, std::size_t n, const Decode& decode);

 private:
  const InputFile& file_;
  std::uint64_t offset_;
  std::size_t stride_;
  tbb::enumerable_thread_specific<std::vector<char>> buffers_;
};

}  // namespace palpate

/// \file
/// Row-by-row access to the Gaussians of a .ply, whatever its encoding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include <palpate/scene/ply_decoder.h>
#include <palpate/scene/ply_scene.h>
#include <palpate/scene/row_reader.h>

namespace palpate {

/// Reads the rows of the element `vertex` from first to last. One thread at a time.
class PlyRows {
 public:
  virtual ~PlyRows() = default;

  /// Decoder of the rows that next() delivers.
  virtual PlyDecoder decoder() const = 0;

  /// Calls `decode` once for each block of the next `n` rows; for binary files, from several threads. \throws
  /// Error where the file is damaged or truncated; whatever `decode` throws.
  virtual void next(std::size_t n, const RowReader::Decode& decode) = 0;

  /// Call after the last row: skips the elements that follow. \returns the number of unexplained bytes at the
  /// end. \throws Error where these elements are damaged or truncated.
  virtual std::uint64_t finish() = 0;
};

/// Opens the rows at the first one. \param ply held by reference. \throws Error for malformed data before
/// `vertex`, or too little data for its rows.
std::unique_ptr<PlyRows> open_rows(const PlyScene& ply);
std::unique_ptr<PlyRows> open_binary_rows(const PlyScene& ply);
std::unique_ptr<PlyRows> open_ascii_rows(const PlyScene& ply);

}  // namespace palpate

/// \file
/// The Gaussians of a .ply as rows of numbers, whatever its encoding.
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

  /// Of the rows that next() gives.
  virtual PlyDecoder decoder() const = 0;

  /// Calls `decode` with every part of the next `n` rows once; where the file is binary, from several
  /// threads. \throws Error where the file is damaged or cut; whatever `decode` throws.
  virtual void next(std::size_t n, const RowReader::Decode& decode) = 0;

  /// After the last row: walks over the elements behind it. \returns the bytes that nothing accounts for.
  /// \throws Error where these elements are damaged or cut.
  virtual std::uint64_t finish() = 0;
};

/// In front of the first row. \param ply is kept by reference.
/// \throws Error for data before `vertex` that are broken, or too little data for its rows.
std::unique_ptr<PlyRows> open_rows(const PlyScene& ply);
std::unique_ptr<PlyRows> open_binary_rows(const PlyScene& ply);
std::unique_ptr<PlyRows> open_ascii_rows(const PlyScene& ply);

}  // namespace palpate

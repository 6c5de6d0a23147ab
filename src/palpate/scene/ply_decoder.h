/// \file
/// Decoder from rows of a .ply to Gaussians.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <palpate/scene/bytes.h>
#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/ply_header.h>
#include <palpate/scene/ply_layout.h>
#include <palpate/scene/ply_materials.h>
#include <palpate/scene/row_reader.h>

namespace palpate {

/// Decodes binary rows of an element `vertex` that has passed check_layout(). Works column by column, so that
/// type and byte order are dispatched once per column and block, not once per number. Const functions may be
/// called from several threads.
class PlyDecoder {
 public:
  PlyDecoder(const PlyElement& vertex, ByteOrder order);

  /// Resizes the optional arrays of `chunk` to its size, for the properties that the file has.
  void size_optional(GaussianScene& chunk) const;

  /// Decodes the rows into the Gaussians `at`, at + 1, ... of `chunk`, except their ids. Positions become
  /// relative to chunk.origin. Values wider than single precision are rounded to it.
  void decode(const RowBlock& rows, GaussianScene& chunk, std::size_t at) const;

  /// Resizes the arrays of `materials` for the properties that the file has.
  void size(PlyMaterials& materials, std::size_t rows) const;
  /// Decodes the rows into `materials`, from row `at` on.
  void decode(const RowBlock& rows, PlyMaterials& materials, std::size_t at) const;

  /// Decodes the colours of the rows into `sh`: for each row the constant SH term of red, green and blue, 0
  /// if the file lacks it, then the coefficients of degrees 1 to `degree` as INRIA orders them: all of red,
  /// all of green, all of blue. \pre `degree` is not above that of the file
  void decode_sh(const RowBlock& rows, int degree, float* sh) const;

  /// The position in one row, as stored in the file.
  Eigen::Vector3d position(const char* row) const;

 private:
  struct Column {
    std::size_t offset;  ///< in a row
    PlyType type;
  };

  bool has(PlyField field) const { return columns_[field].has_value(); }

  /// Calls use(k, value) with the exact value in `column`, for every row k.
  template <typename Use>
  void for_each(const Column& column, const RowBlock& rows, const Use& use) const;
  /// The same for the column of `field`.
  template <typename Use>
  void for_each(PlyField field, const RowBlock& rows, const Use& use) const {
    for_each(*columns_[field], rows, use);
  }

  std::array<std::optional<Column>, kPlyFieldCount> columns_;
  std::vector<Column> rest_;  ///< of f_rest_0, f_rest_1, ...
  ByteOrder order_;
};

}  // namespace palpate

/// \file
/// Tables of numbers in CSV files with a header line.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/base/file.h>
#include <palpate/base/progress.h>

namespace palpate {

/// A table of doubles, row by row.
struct CsvTable {
  std::string source;                ///< file name, for messages
  std::vector<std::string> columns;  ///< names, from the header line
  std::vector<double> values;        ///< rows() * columns.size(), row-major

  std::vector<std::size_t> lines;  ///< of each row: its line in the file, from 1, for messages

  std::size_t rows() const { return columns.empty() ? 0 : values.size() / columns.size(); }
  double at(std::size_t row, std::size_t column) const { return values[row * columns.size() + column]; }

  /// Index of the column `name`. \throws Error if there is none.
  std::size_t column(std::string_view name) const;
  bool has(std::string_view name) const;
};

/// Reads a CSV file of finite numbers: one header line of distinct names, then rows of as many
/// numbers; LF or CR LF; blank lines are skipped.
/// \throws Error naming the line and column of the first thing that is not so.
CsvTable read_csv(const std::string& path, const Progress& progress = {});

/// Appends `values` as one line, each number as short as reads back exactly.
void append_csv_row(std::string& out, std::span<const double> values);

}  // namespace palpate

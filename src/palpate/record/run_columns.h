/// \file
/// Columns of a run: the single definition that files, validation and web pages are made from.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/base/csv.h>
#include <palpate/record/run_row.h>

namespace palpate {

/// Groups of columns. A run has all or none of a group, except columns with RunColumn::may_lack.
enum class ColumnGroup : std::uint8_t {
  kAlways,
  kUserForce,  ///< RunRow::user_force
  kLive,       ///< RunRow::live
};

/// One column.
struct RunColumn {
  std::string_view name;
  std::string_view unit;  ///< "1" if dimensionless
  std::string_view help;  ///< short description
  ColumnGroup group;
  double (*get)(const RunRow& row);        ///< 0 where the row lacks the group
  void (*set)(RunRow& row, double value);  ///< adds the group to the row. \pre takes(value)
  int digits = 7;                          ///< significant digits shown on a page; 0: not shown
  std::string_view whole_number = {};  ///< what an integer counts or enumerates; empty for a measured value
  double most = 0.0;                   ///< maximum of an integer; the minimum is 0
  /// Words that files use in place of integers, indexed by the integer; empty: integers are used. Recordings
  /// of earlier versions have integers.
  std::span<const std::string_view> words = {};
  bool may_lack = false;  ///< absent from recordings of earlier versions; reads as 0

  /// True if `value` is valid for this column.
  bool takes(double value) const;
};

/// Optional column groups of a run.
struct RunGroups {
  bool user_force = false;
  bool live = false;

  /// Groups of a run whose first row is this one.
  static RunGroups of(const RunRow& row);
  bool has(ColumnGroup group) const;
};

/// All existing columns, in the order of the file. The first is the time.
std::span<const RunColumn> run_columns();
/// Columns of a run, in the order of the file.
std::vector<RunColumn> run_columns(const RunGroups& groups);

/// Lets `reader` accept the words of the columns that have them.
void take_run_words(CsvReader& reader);

/// The header line, with its terminator.
std::string run_header(std::span<const RunColumn> columns);
/// Appends the line of a row, with its terminator. Numbers read back exactly. \param columns a subset of
/// run_columns()
void append_run_row(std::string& out, const RunRow& row, std::span<const RunColumn> columns);

}  // namespace palpate

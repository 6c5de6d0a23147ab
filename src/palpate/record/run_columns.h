/// \file
/// The columns of a run: the one list that files, their checks and pages are made from.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/base/csv.h>
#include <palpate/record/run_row.h>

namespace palpate {

/// Columns that a run has all of or none of, but for those that RunColumn::may_lack.
enum class ColumnGroup : std::uint8_t {
  kAlways,
  kUserForce,  ///< RunRow::user_force
  kLive,       ///< RunRow::live
};

/// One column.
struct RunColumn {
  std::string_view name;
  std::string_view unit;  ///< "1" of what has none
  std::string_view help;  ///< what it is, in a few words
  ColumnGroup group;
  double (*get)(const RunRow& row);        ///< 0 where the row lacks the group
  void (*set)(RunRow& row, double value);  ///< gives the row the group. \pre takes(value)
  int digits = 7;                          ///< significant ones that a page needs; 0: it shows nothing of it
  std::string_view whole_number = {};      ///< what a value counts or numbers; empty if it is measured
  double most = 0.0;                       ///< of a whole number; the least is 0
  /// What files have in place of the whole numbers, each at its number; empty: the numbers. Recordings of
  /// earlier versions have numbers.
  std::span<const std::string_view> words = {};
  bool may_lack = false;  ///< recordings of earlier versions do not have it; it reads as 0

  /// `value` is one that this column may hold.
  bool takes(double value) const;
};

/// Which columns a run has besides those that are always there.
struct RunGroups {
  bool user_force = false;
  bool live = false;

  /// Of a run that begins with this row.
  static RunGroups of(const RunRow& row);
  bool has(ColumnGroup group) const;
};

/// All columns that there are, in the order of the file. The first is the time.
std::span<const RunColumn> run_columns();
/// Those of a run, in the order of the file.
std::vector<RunColumn> run_columns(const RunGroups& groups);

/// Has `reader` take the words of the columns that have some.
void take_run_words(CsvReader& reader);

/// The line of names, with its end.
std::string run_header(std::span<const RunColumn> columns);
/// Appends the line of a row, with its end. Numbers read back exactly. \param columns some of run_columns()
void append_run_row(std::string& out, const RunRow& row, std::span<const RunColumn> columns);

}  // namespace palpate

/// \file
/// Columns of evaluation results for tables, CSV and JSON.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include <palpate/report/ordered_json.h>

namespace palpate {

/// One result column of a row type.
template <class Row>
struct FigureColumn {
  const char* name;     ///< in CSV and JSON
  const char* heading;  ///< in a table; null: not shown there
  const char* format;
  double (*value)(const Row&);  ///< NaN if there is none
};

/// Factors from SI units, and formats, of figures in tables.
inline constexpr double kToMm = 1e3, kPercent = 100.0;
inline constexpr const char *kMm = "{:.2f}", *kCount = "{:.0f}";

/// Width of a column in a table: that of its heading, and at least `least`.
template <class Row>
std::size_t width_of(const FigureColumn<Row>& column, std::size_t least) {
  return std::max(least, std::string_view(column.heading).size());
}

/// Formats a figure; a dash if there is none.
template <class Row>
std::string text_of(const FigureColumn<Row>& column, const Row& row) {
  const double value = column.value(row);
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(column.format), value);
}

/// Adds the row's figures to an object; null if there is none.
template <class Row>
void put_figures(const std::vector<FigureColumn<Row>>& columns, const Row& row, OrderedJson& json) {
  for (const FigureColumn<Row>& column : columns) {
    const double value = column.value(row);
    json[column.name] = std::isnan(value) ? OrderedJson() : OrderedJson(value);
  }
}

/// Returns the column names for the first line of CSV, each preceded by a comma.
template <class Row>
std::string csv_names(const std::vector<FigureColumn<Row>>& columns) {
  std::string text;
  for (const FigureColumn<Row>& column : columns) text += fmt::format(",{}", column.name);
  return text;
}

/// Returns the row's figures for a line of CSV, each preceded by a comma; empty if there is none.
template <class Row>
std::string csv_figures(const std::vector<FigureColumn<Row>>& columns, const Row& row) {
  std::string text;
  for (const FigureColumn<Row>& column : columns) {
    const double value = column.value(row);
    text += std::isnan(value) ? "," : fmt::format(",{}", value);
  }
  return text;
}

}  // namespace palpate

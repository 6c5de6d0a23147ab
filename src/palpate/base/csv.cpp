#include <palpate/base/csv.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include <palpate/base/error.h>

namespace palpate {
namespace {

constexpr std::size_t kMaxColumns = 1000;                    // a hostile header must not cost quadratic time
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  // as spreadsheets write it
constexpr std::uint64_t kMaxBytes = std::uint64_t{4} << 30;

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Calls visit(cell) for every comma-separated cell of `line`.
template <typename Visit>
void for_each_cell(std::string_view line, Visit&& visit) {
  for (;;) {
    const std::size_t comma = line.find(',');
    visit(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

void read_header(CsvTable& table, std::string_view line) {
  for_each_cell(line, [&](std::string_view name) {
    if (table.columns.size() == kMaxColumns) {
      throw Error("{}: line 1: more than {} columns; it is not a table of this kind", table.source,
                  kMaxColumns);
    }
    if (name.empty())
      throw Error("{}: line 1: column {} has no name", table.source, table.columns.size() + 1);
    if (table.has(name)) throw Error("{}: line 1: two columns are called '{}'", table.source, name);
    table.columns.emplace_back(name);
  });
}

void read_row(CsvTable& table, std::string_view line, std::size_t line_number) {
  const std::size_t width = table.columns.size();
  const std::size_t before = table.values.size();
  for_each_cell(line, [&](std::string_view cell) {
    const std::size_t k = table.values.size() - before;
    if (k == width) throw Error("{}: line {}: more than {} values", table.source, line_number, width);
    double value = 0.0;
    const auto [end, error] = std::from_chars(cell.begin(), cell.end(), value);
    if (cell.empty() || error != std::errc{} || end != cell.end() || !std::isfinite(value)) {
      throw Error("{}: line {}: column '{}': '{}' is not a finite number", table.source, line_number,
                  table.columns[k], cell);
    }
    table.values.push_back(value);
  });
  if (table.values.size() - before != width) {
    throw Error("{}: line {}: {} values for {} columns; the line is cut", table.source, line_number,
                table.values.size() - before, width);
  }
}

}  // namespace

std::size_t CsvTable::column(std::string_view name) const {
  const auto found = std::find(columns.begin(), columns.end(), name);
  if (found == columns.end())
    throw Error("{}: line 1: column '{}' is missing; the header must name it", source, name);
  return static_cast<std::size_t>(found - columns.begin());
}

bool CsvTable::has(std::string_view name) const {
  return std::find(columns.begin(), columns.end(), name) != columns.end();
}

CsvTable read_csv(const std::string& path, const Progress& progress) {
  constexpr std::size_t kLinesPerReport = 1 << 16;
  const std::string text = read_text_file(path, kMaxBytes);
  CsvTable table;
  table.source = path;
  std::string_view rest = text;
  if (rest.starts_with(kByteOrderMark)) rest.remove_prefix(kByteOrderMark.size());
  for (std::size_t line_number = 1; !rest.empty(); ++line_number) {
    const std::size_t end = rest.find('\n');
    const std::string_view line = trimmed(rest.substr(0, end));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    if (line_number == 1) {
      read_header(table, line);
    } else if (!line.empty()) {
      read_row(table, line, line_number);
      table.lines.push_back(line_number);
    }
    if (line_number % kLinesPerReport == 0) {
      report(progress, "reading", 1.0 - static_cast<double>(rest.size()) / static_cast<double>(text.size()));
    }
  }
  if (table.columns.empty()) throw Error("{}: is empty; a header line and rows are needed", path);
  return table;
}

void append_csv_row(std::string& out, std::span<const double> values) {
  const char* separator = "";
  for (const double v : values) {
    fmt::format_to(std::back_inserter(out), "{}{}", separator, v);
    separator = ",";
  }
  out += '\n';
}

}  // namespace palpate

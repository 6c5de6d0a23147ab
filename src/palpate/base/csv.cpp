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

/// Calls visit(cell, it is the last one) for every comma-separated cell of `line`.
template <typename Visit>
void for_each_cell(std::string_view line, Visit&& visit) {
  for (;;) {
    const std::size_t comma = line.find(',');
    visit(trimmed(line.substr(0, comma)), comma == std::string_view::npos);
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

CsvHeader read_header(const std::string& source, std::string_view line) {
  CsvHeader header{source, {}};
  for_each_cell(line, [&](std::string_view name, bool) {
    if (header.columns.size() == kMaxColumns) {
      throw Error("{}: line 1: more than {} columns; it is not a table of this kind", source, kMaxColumns);
    }
    if (name.empty()) throw Error("{}: line 1: column {} has no name", source, header.columns.size() + 1);
    if (header.has(name)) throw Error("{}: line 1: two columns are called '{}'", source, name);
    header.columns.emplace_back(name);
  });
  return header;
}

/// True if more characters could make it a number.
bool begins_a_number(std::string_view cell) {
  return cell.find_first_not_of("0123456789+-.eE") == std::string_view::npos;
}

}  // namespace

std::size_t CsvHeader::column(std::string_view name) const {
  const auto found = std::find(columns.begin(), columns.end(), name);
  if (found == columns.end())
    throw Error("{}: line 1: column '{}' is missing; the header must name it", source, name);
  return static_cast<std::size_t>(found - columns.begin());
}

bool CsvHeader::has(std::string_view name) const {
  return std::find(columns.begin(), columns.end(), name) != columns.end();
}

CsvReader::CsvReader(const std::string& path, LastLine last_line) : file_(path), last_line_(last_line) {
  const auto line = lines_.emplace(file_, 0).next();
  if (!line) throw Error("{}: is empty; a header line and rows are needed", path);
  std::string_view names = trimmed(lines_->line_number() == 1 ? *line : "");
  while (names.starts_with(kByteOrderMark)) names = trimmed(names.substr(kByteOrderMark.size()));
  header_ = read_header(path, names);
  row_.reserve(header_.columns.size());
}

std::optional<std::span<const double>> CsvReader::next() {
  const auto line = lines_->next();
  if (!line) return std::nullopt;
  row_.clear();
  for_each_cell(*line, [&](std::string_view cell, bool last) { cut_ = !read_cell(cell, last); });
  if (!cut_ && row_.size() != header_.columns.size()) {
    cut_ = may_be_cut();
    if (!cut_) {
      throw Error("{}: {}: {} values for {} columns; the line is cut", header_.source, where(), row_.size(),
                  header_.columns.size());
    }
  }
  if (cut_) return std::nullopt;
  return row_;
}

/// False if the cell is the cut end of the file. \param last of its line
bool CsvReader::read_cell(std::string_view cell, bool last) {
  const std::size_t width = header_.columns.size();
  if (row_.size() == width) throw Error("{}: {}: more than {} values", header_.source, where(), width);
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.begin(), cell.end(), value);
  if (cell.empty() || error != std::errc{} || end != cell.end() || !std::isfinite(value)) {
    if (last && may_be_cut() && begins_a_number(cell)) return false;
    throw Error("{}: {}: column '{}': '{}' is not a finite number", header_.source, where(),
                header_.columns[row_.size()], cell);
  }
  row_.push_back(value);
  return true;
}

void CsvReader::seek(std::uint64_t offset) {
  lines_.emplace(file_, offset).skip_line();
  sought_ = true;
  cut_ = false;
}

std::string CsvReader::where() const {
  return sought_ ? fmt::format("byte {}", row_start()) : fmt::format("line {}", line());
}

CsvTable read_csv(const std::string& path, const Progress& progress) {
  constexpr std::size_t kRowsPerReport = 1 << 16;
  CsvReader reader(path);
  if (reader.size() > kMaxBytes) {
    throw Error("{}: is {} bytes, more than the {} this kind of file may have", path, reader.size(),
                kMaxBytes);
  }
  CsvTable table{reader.header(), {}, {}};
  while (const auto row = reader.next()) {
    table.values.insert(table.values.end(), row->begin(), row->end());
    table.lines.push_back(reader.line());
    if (table.lines.size() % kRowsPerReport == 0) {
      report(progress, "reading",
             static_cast<double>(reader.row_start()) / static_cast<double>(reader.size()));
    }
  }
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

#include <palpate/base/csv.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <palpate/base/error.h>

namespace palpate {
namespace {

constexpr std::size_t kMaxColumns = 1000;                    // a hostile header must not cost quadratic time
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  // written by spreadsheets
constexpr std::uint64_t kMaxBytes = std::uint64_t{4} << 30;

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Calls visit(cell, is_last) for every comma-separated cell of `line`.
template <typename Visit>
void for_each_cell(std::string_view line, Visit&& visit) {
  for (;;) {
    const std::size_t comma = line.find(',');
    visit(trimmed(line.substr(0, comma)), comma == std::string_view::npos);
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

/// Reads the names of `line` into `header`.
void read_names(CsvHeader& header, std::string_view line) {
  const std::string where = fmt::format("{}: line {}", header.source, header.line);
  for_each_cell(line, [&](std::string_view name, bool) {
    if (header.columns.size() == kMaxColumns)
      throw Error("{}: more than {} columns; not a valid table", where, kMaxColumns);
    if (name.empty()) throw Error("{}: column {} has no name", where, header.columns.size() + 1);
    if (header.has(name)) throw Error("{}: two columns are named '{}'", where, name);
    header.columns.emplace_back(name);
  });
}

bool is_number(std::string_view cell) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.begin(), cell.end(), value);
  return error == std::errc{} && end == cell.end();
}

/// Refuses files of another kind by their first line, of which reading cells would only say that they are
/// bad.
void refuse_other_kinds(const CsvHeader& header, std::string_view line) {
  const std::string where = fmt::format("{}: line {}", header.source, header.line);
  if (line == "ply") throw Error("{}: is a .ply file; a table (.csv) is needed", header.source);
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 && c != '\t'; };
  if (std::any_of(line.begin(), line.end(), is_control))
    throw Error("{}: is binary; a table (.csv) is needed", where);
  if (line.find(',') == std::string_view::npos) {
    for (const auto& [separator, name] : {std::pair(';', "semicolons"), std::pair('\t', "tabs")}) {
      if (line.find(separator) != std::string_view::npos)
        throw Error("{}: columns are separated by {}; separate them by commas", where, name);
    }
  }
  bool all_numbers = true;
  for_each_cell(line, [&](std::string_view cell, bool) { all_numbers = all_numbers && is_number(cell); });
  if (all_numbers)
    throw Error("{}: has numbers and no column names; add a header line, such as t,x,y,z", where);
}

/// Returns true if `cell` may be the start of a number or of one of `words`.
bool may_become_one(std::string_view cell, std::span<const std::string_view> words) {
  return cell.find_first_not_of("0123456789+-.eE") == std::string_view::npos ||
         std::any_of(words.begin(), words.end(), [&](auto word) { return word.starts_with(cell); });
}

/// \param line without white space around it
void add_to_comment(CsvHeader& header, std::string_view line) {
  line.remove_prefix(1);
  if (line.starts_with(' ')) line.remove_prefix(1);
  if (header.comment.size() + line.size() >= CsvReader::kMaxComment) {
    throw Error("{}: line {}: more than {} bytes of comment; not a valid table", header.source, header.line,
                CsvReader::kMaxComment);
  }
  header.comment += line;
  header.comment += '\n';
}

}  // namespace

std::size_t CsvHeader::column(std::string_view name) const {
  const auto found = std::find(columns.begin(), columns.end(), name);
  if (found == columns.end())
    throw Error("{}: line {}: column '{}' is missing; the header must name it", source, line, name);
  return static_cast<std::size_t>(found - columns.begin());
}

bool CsvHeader::has(std::string_view name) const {
  return std::find(columns.begin(), columns.end(), name) != columns.end();
}

CsvReader::CsvReader(const std::string& path, LastLine last_line) : file_(path), last_line_(last_line) {
  header_.source = path;
  lines_.emplace(file_, 0);
  std::optional<std::string_view> line;
  for (;; ++header_.line) {
    line = lines_->next();
    if (!line) throw Error("{}: is empty; a header line and rows are needed", path);
    line = trimmed(lines_->line_number() == header_.line ? *line : "");
    while (line->starts_with(kByteOrderMark)) line = trimmed(line->substr(kByteOrderMark.size()));
    if (!line->starts_with('#')) break;
    add_to_comment(header_, *line);
  }
  refuse_other_kinds(header_, *line);
  read_names(header_, *line);
  words_.resize(header_.columns.size());
  ignored_.resize(header_.columns.size());
  row_.reserve(header_.columns.size());
}

void CsvReader::ignore_all_but(std::span<const std::string_view> names) {
  for (std::size_t k = 0; k < header_.columns.size(); ++k) {
    if (std::find(names.begin(), names.end(), header_.columns[k]) == names.end()) ignore(k);
  }
}

std::optional<std::span<const double>> CsvReader::next() {
  const auto line = lines_->next();
  if (!line) return std::nullopt;
  row_.clear();
  for_each_cell(*line, [&](std::string_view cell, bool last) { cut_ = !read_cell(cell, last); });
  if (!cut_ && row_.size() != header_.columns.size()) {
    cut_ = may_be_cut();
    if (!cut_) {
      throw Error("{}: {}: {} values for {} columns; the line is truncated", header_.source, where(),
                  row_.size(), header_.columns.size());
    }
  }
  if (cut_) return std::nullopt;
  return row_;
}

/// Appends the value of a cell to row_. \returns false if the cell is the truncated end of the file. \param
/// last cell of its line
bool CsvReader::read_cell(std::string_view cell, bool last) {
  const std::size_t width = header_.columns.size();
  if (row_.size() == width) throw Error("{}: {}: more than {} values", header_.source, where(), width);
  if (ignored_[row_.size()] != 0) {
    row_.push_back(0.0);
    return true;
  }
  const std::span<const std::string_view> words = words_[row_.size()];
  if (const auto word = std::find(words.begin(), words.end(), cell); word != words.end()) {
    row_.push_back(static_cast<double>(word - words.begin()));
    return true;
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.begin(), cell.end(), value);
  if (cell.empty() || error != std::errc{} || end != cell.end() || !std::isfinite(value)) {
    if (last && may_be_cut() && may_become_one(cell, words)) return false;
    throw Error("{}: {}: column '{}': '{}' is not {}", header_.source, where(), header_.columns[row_.size()],
                cell, words.empty() ? "a finite number" : fmt::format("one of {}", fmt::join(words, ", ")));
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
  CsvReader reader(path);
  return read_csv(reader, progress);
}

CsvTable read_csv(CsvReader& reader, const Progress& progress) {
  constexpr std::size_t kRowsPerReport = 1 << 16;
  if (reader.size() > kMaxBytes) {
    throw Error("{}: has {} bytes; the limit for such a file is {}", reader.header().source, reader.size(),
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

std::string csv_comment(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    out += fmt::format("# {}\n", text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
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

/// \file
/// CSV tables of numbers with a header line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/base/file.h>
#include <palpate/base/line_reader.h>
#include <palpate/base/progress.h>

namespace palpate {

/// Header of a CSV file: comment and column names.
struct CsvHeader {
  std::string source;                ///< file name, for messages
  std::vector<std::string> columns;  ///< names
  std::string comment;               ///< see csv_comment(); empty if the file has none
  std::size_t line = 1;              ///< line number of the column names, from 1

  /// Index of the column `name`. \throws Error if there is none.
  std::size_t column(std::string_view name) const;
  bool has(std::string_view name) const;
};

/// Reads a CSV file of finite numbers row by row, in bounded memory. Format: optional comment lines that
/// begin with '#'; one header line of distinct names, of which at least one is no number; then rows with one
/// number per column. Lines end in LF or CR LF; blank lines are skipped. One thread at a time.
class CsvReader {
 public:
  /// How to treat a last line that has no terminator and too few values or a truncated number.
  enum class LastLine {
    kWhole,     ///< an error, as on any other line
    kMaybeCut,  ///< the writer was interrupted: the line is dropped
  };

  /// Maximum length of the comment. Unit: [bytes].
  static constexpr std::size_t kMaxComment = std::size_t{1} << 18;

  /// \throws Error if the file cannot be read or its header is invalid.
  explicit CsvReader(const std::string& path, LastLine last_line = LastLine::kWhole);

  const CsvHeader& header() const { return header_; }
  /// Size of the file when it was opened. Unit: [bytes].
  std::uint64_t size() const { return file_.size(); }

  /// Lets cells of this column also be one of `words`, which reads as its index among them. \param words must
  /// outlive this object
  void take_words(std::size_t column, std::span<const std::string_view> words) { words_[column] = words; }

  /// Lets cells of this column hold anything but a comma; they read as 0.
  void ignore(std::size_t column) { ignored_[column] = 1; }
  /// Ignores all columns but those of these names.
  void ignore_all_but(std::span<const std::string_view> names);

  /// The next row, valid until the next call; nothing at the end. \throws Error naming the place of the first
  /// row that is not made of finite numbers.
  std::optional<std::span<const double>> next();

  /// Seeks to the first line that begins after byte `offset`. \pre `offset` is not in the header line
  void seek(std::uint64_t offset);

  /// \name The row that next() returned last
  /// @{
  std::uint64_t row_start() const { return lines_->line_start(); }  ///< Unit: [bytes].
  std::size_t line() const { return lines_->line_number(); }        ///< in the file, from 1. \pre no seek()
  bool terminated() const { return lines_->terminated(); }          ///< its line has a terminator
  std::string where() const;  ///< for messages: "line 3", or "byte 1234" after a seek()
  /// @}

  /// True if next() has dropped a truncated last line.
  bool cut() const { return cut_; }

 private:
  bool read_cell(std::string_view cell, bool last);
  bool may_be_cut() const { return last_line_ == LastLine::kMaybeCut && !terminated(); }

  InputFile file_;
  LastLine last_line_;
  std::optional<LineReader> lines_;
  CsvHeader header_;
  std::vector<std::span<const std::string_view>> words_;  ///< by column; empty for numbers alone
  std::vector<char> ignored_;                             ///< by column: nobody wants it
  std::vector<double> row_;
  bool sought_ = false;
  bool cut_ = false;
};

/// A table of doubles, row by row.
struct CsvTable : CsvHeader {
  std::vector<double> values;  ///< rows() * columns.size(), row-major

  std::vector<std::size_t> lines;  ///< line number of each row in the file, from 1, for messages

  std::size_t rows() const { return columns.empty() ? 0 : values.size() / columns.size(); }
  double at(std::size_t row, std::size_t column) const { return values[row * columns.size() + column]; }
};

/// Reads a whole CSV file as CsvReader does. \throws Error naming the line and column of the first cell that
/// is invalid.
CsvTable read_csv(const std::string& path, const Progress& progress = {});
/// The rows that `reader` has not read yet.
CsvTable read_csv(CsvReader& reader, const Progress& progress = {});

/// The lines of `text` as comment lines, each prefixed with "# ".
std::string csv_comment(std::string_view text);

/// Appends `values` as one line, each number in the shortest form that reads back exactly.
void append_csv_row(std::string& out, std::span<const double> values);

}  // namespace palpate

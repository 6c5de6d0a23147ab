/// \file
/// Line-by-line reader of a text file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <palpate/base/file.h>

namespace palpate {

/// Reads the lines of a text file from an offset on, without their terminators.
class LineReader {
 public:
  /// \param file held by reference.
  LineReader(const InputFile& file, std::uint64_t offset);

  /// The next line that is not blank, valid until the next call; nothing at the end of the file.
  /// \throws Error when the read fails or a line is unreasonably long.
  std::optional<std::string_view> next();

  /// Skips past the next terminator, or to the end of the file if there is none. \throws Error when the read
  /// fails.
  void skip_line();

  /// Byte offset in the file of the line that next() returned last.
  std::uint64_t line_start() const { return line_start_; }
  /// Number of that line counted from the initial offset, from 1; blank lines count.
  std::uint64_t line_number() const { return line_number_; }
  /// True if that line has a terminator; the last of a file may have none.
  bool terminated() const { return terminated_; }
  /// Bytes of the file after that line.
  std::uint64_t bytes_left() const { return file_.size() - position(); }

 private:
  /// Byte offset in the file at which next() continues.
  std::uint64_t position() const { return next_read_ - (buffer_.size() - at_); }
  bool refill();

  const InputFile& file_;
  std::string buffer_;
  std::size_t at_ = 0;
  std::uint64_t next_read_;
  std::uint64_t line_start_;
  std::uint64_t line_number_ = 0;
  bool terminated_ = false;
};

}  // namespace palpate

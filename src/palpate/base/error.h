/// \file
/// The library's only exception type.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/core.h>

namespace palpate {

/// `text` as valid UTF-8 without control characters, each of which becomes '?'. File names and the
/// contents of files come from outside: they must not forge a second line, nor reach a terminal as
/// an escape sequence.
std::string printable(std::string_view text);

/// `text` as one printable line of bounded length; the middle of a long one is cut out.
std::string message_line(std::string_view text);

/// Thread-safe strerror().
std::string error_text(int error_number);

/// Invalid input or a failed file operation. The message is one line that says what is wrong, where (file and
/// offset, property or field) and what to do; programs print it unchanged. Thrown by loading, configuration
/// and writing only: nothing in the servo path throws.
class Error : public std::runtime_error {
 public:
  template <typename... Args>
  explicit Error(fmt::format_string<Args...> format, Args&&... args)
      : std::runtime_error(message_line(fmt::format(format, std::forward<Args>(args)...))) {}
};

}  // namespace palpate

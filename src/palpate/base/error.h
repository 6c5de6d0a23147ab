/// \file
/// The one exception type of the library.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/core.h>

namespace palpate {

/// Bad input or a failed operation on a file. The message is one line that says what is wrong,
/// where (file and offset, property or field) and what to do; programs print it as it is.
/// Thrown by loading, configuration and writing only: nothing in the servo path throws.
class Error : public std::runtime_error {
 public:
  template <typename... Args>
  explicit Error(fmt::format_string<Args...> format, Args&&... args)
      : std::runtime_error(one_line(fmt::format(format, std::forward<Args>(args)...))) {}

 private:
  /// File names and header lines come from outside: control characters in them must not forge a
  /// second line or an escape sequence on a terminal.
  static std::string one_line(std::string text) {
    for (char& c : text) {
      const auto code = static_cast<unsigned char>(c);
      if (code < 0x20 || code == 0x7f) c = '?';
    }
    return text;
  }
};

}  // namespace palpate

/// \file
/// Single key presses from the terminal.
#pragma once

#include <optional>

#include <termios.h>

namespace palpate::cli {

/// Reads single keys from the terminal on standard input, without echo, and restores its mode on destruction.
/// Without a terminal there are no keys.
class Keyboard {
 public:
  Keyboard();
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  bool there() const { return there_; }
  /// Returns the next key, if one is pressed within `seconds`.
  std::optional<char> key(double seconds);

 private:
  bool there_ = false;
  termios before_{};
};

}  // namespace palpate::cli

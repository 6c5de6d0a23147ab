/// \file
/// Keys, as they are pressed.
#pragma once

#include <optional>

#include <termios.h>

namespace palpate::cli {

/// Takes single keys from the terminal on standard input, without echo, and gives it back as it was. Where
/// standard input is no terminal there are no keys.
class Keyboard {
 public:
  Keyboard();
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  bool there() const { return there_; }
  /// The next key, if one is pressed within `seconds`.
  std::optional<char> key(double seconds);

 private:
  bool there_ = false;
  termios before_{};
};

}  // namespace palpate::cli

#include "keyboard.h"

#include <poll.h>
#include <unistd.h>

namespace palpate::cli {

Keyboard::Keyboard() {
  if (::isatty(STDIN_FILENO) == 0 || ::tcgetattr(STDIN_FILENO, &before_) != 0) return;
  // In the background, changing the terminal mode would stop the process (SIGTTOU).
  if (::tcgetpgrp(STDIN_FILENO) != ::getpgrp()) return;
  termios single = before_;
  single.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  there_ = ::tcsetattr(STDIN_FILENO, TCSANOW, &single) == 0;
}

Keyboard::~Keyboard() {
  if (there_) ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

std::optional<char> Keyboard::key(double seconds) {
  pollfd input{there_ ? STDIN_FILENO : -1, POLLIN, 0};
  const int ready = ::poll(&input, 1, static_cast<int>(1000.0 * seconds));
  char pressed = 0;
  if (ready <= 0 || ::read(STDIN_FILENO, &pressed, 1) != 1) {
    if (ready > 0) there_ = false;  // the terminal is gone
    return std::nullopt;
  }
  return pressed;
}

}  // namespace palpate::cli

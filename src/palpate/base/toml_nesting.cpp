#include <palpate/base/toml_nesting.h>

#include <algorithm>
#include <vector>

namespace palpate {
namespace {

/// Length of the string at the start of `text`, quotes included: 0 if there is none, all of `text` if it is
/// not terminated.
std::size_t string_bytes(std::string_view text) {
  const char quote = text.front();
  if (quote != '"' && quote != '\'') return 0;
  const std::string_view three = quote == '"' ? R"(""")" : "'''";
  const std::string_view mark = text.starts_with(three) ? three : three.substr(0, 1);
  std::size_t end = mark.size();
  while (end < text.size() && !text.substr(end).starts_with(mark))
    end += quote == '"' && text[end] == '\\' ? 2 : 1;
  end = std::min(end + mark.size(), text.size());
  // A triple-quoted string may end with quotes of its own, before the closing ones.
  while (mark == three && end < text.size() && text[end] == quote) ++end;
  return end;
}

/// Length of the string or comment at the start of `text`, which does not affect nesting; 0 if there is none.
std::size_t opaque_bytes(std::string_view text) {
  if (text.front() == '#') return std::min(text.find('\n'), text.size());
  return string_bytes(text);
}

/// Nesting depth at the end of the text fed so far.
class Nesting {
 public:
  std::size_t depth() const { return depth_; }

  void feed(char c) {
    switch (c) {
      case '.': ++dots_, ++depth_; break;
      case '[':
      case '{': open(); break;
      case ']':
      case '}': close(); break;
      case ',':
      case '\n': leave_key(); break;
      default: break;
    }
  }

 private:
  void leave_key() {
    depth_ -= dots_;
    dots_ = 0;
  }

  void open() {
    dots_around_.push_back(dots_);
    dots_ = 0;
    ++depth_;
  }

  void close() {
    leave_key();
    if (dots_around_.empty()) return;
    dots_ = dots_around_.back();
    dots_around_.pop_back();
    --depth_;
  }

  std::size_t depth_ = 0;
  std::size_t dots_ = 0;                  ///< in the current key, or number
  std::vector<std::size_t> dots_around_;  ///< dots_ around each open bracket
};

}  // namespace

std::optional<std::size_t> line_nested_deeper(std::string_view text, std::size_t most) {
  Nesting nesting;
  std::size_t line = 1;
  while (!text.empty()) {
    const std::size_t skipped = opaque_bytes(text);
    if (skipped == 0) nesting.feed(text.front());
    if (nesting.depth() > most) return line;
    const std::string_view done = text.substr(0, std::max<std::size_t>(skipped, 1));
    line += static_cast<std::size_t>(std::count(done.begin(), done.end(), '\n'));
    text.remove_prefix(done.size());
  }
  return std::nullopt;
}

}  // namespace palpate

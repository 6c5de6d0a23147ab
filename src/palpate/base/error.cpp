#include <palpate/base/error.h>

#include <algorithm>
#include <cstddef>
#include <system_error>

namespace palpate {
namespace {

/// Bytes of the UTF-8 sequence at the start of `text`; 0 if there is none, or if it is a control
/// character.
std::size_t printable_bytes(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  if (first == 0xc2 && byte(1) < 0xa0) return 0;   // C1 controls
  if (first == 0xe0 && byte(1) < 0xa0) return 0;   // overlong
  if (first == 0xed && byte(1) >= 0xa0) return 0;  // surrogates
  if (first == 0xf0 && byte(1) < 0x90) return 0;   // overlong
  if (first == 0xf4 && byte(1) >= 0x90) return 0;  // beyond Unicode
  if (first == 0xe2 && byte(1) == 0x80 && byte(2) >= 0xa8 && byte(2) <= 0xae)
    return 0;  // line separators, bidirectional embeddings
  if (first == 0xe2 && byte(1) == 0x81 && byte(2) >= 0xa6 && byte(2) <= 0xa9)
    return 0;  // bidirectional isolates
  return length;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t n = printable_bytes(text);
    if (n == 0) {
      out += '?';
    } else {
      out += text.substr(0, n);
    }
    text.remove_prefix(std::max<std::size_t>(n, 1));
  }
  return out;
}

std::string message_line(std::string_view text) {
  constexpr std::size_t kHead = 280;  // what is wrong and where
  constexpr std::size_t kTail = 120;  // what to do
  std::string line = printable(text);
  if (line.size() > kHead + kTail) {
    // A cut inside a UTF-8 sequence is repaired by printable(), which turns the remaining bytes into '?'.
    line = printable(line.substr(0, kHead)) + " ... " + printable(line.substr(line.size() - kTail));
  }
  return line;
}

std::string error_text(int error_number) { return std::generic_category().message(error_number); }

}  // namespace palpate

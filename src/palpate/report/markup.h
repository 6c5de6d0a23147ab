/// \file
/// Escaping of text for HTML and SVG.
#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// Returns `text` escaped for use between two tags.
inline std::string markup_escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '&': out += "&amp;"; break;
      default: out += c;
    }
  }
  return out;
}

}  // namespace palpate

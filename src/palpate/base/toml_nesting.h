/// \file
/// Nesting depth of a TOML text, without parsing it.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace palpate {

/// The first line, from 1, at which `text` is nested more than `most` levels deep; nothing if there is none.
/// A bracket, a brace and a dot of a key are one level each. Exact up to the first syntax error in `text`,
/// where a parser stops.
std::optional<std::size_t> line_nested_deeper(std::string_view text, std::size_t most);

}  // namespace palpate

/// \file
/// How deeply a TOML text nests, without parsing it.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace palpate {

/// The line, from 1, where `text` is nested more than `most` deep for the first time; nothing if it never is.
/// A bracket, a brace and a dot of a key are a level each. Up to the first mistake in `text` the answer is
/// exact; a parser stops there.
std::optional<std::size_t> line_nested_deeper(std::string_view text, std::size_t most);

}  // namespace palpate

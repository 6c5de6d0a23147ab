/// \file
/// Suggestions for mistyped names.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace palpate {

/// Returns the least number of letters to insert, remove or replace to turn one text into the other
/// (Levenshtein's distance).
std::size_t edit_distance(std::string_view a, std::string_view b);

/// Returns the name of an option that `argument` ("--name", "--name=value") resembles: one name begins with
/// the other, or few letters differ; of several, the first of those nearest. Empty if there is none, or if
/// `argument` does not begin with a dash. \param names long names of options, without dashes
std::string similar_option(std::string argument, std::span<const std::string> names);

}  // namespace palpate

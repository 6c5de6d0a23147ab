#include <palpate/base/similar_name.h>

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace palpate {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j - 1] + 1, row[j] + 1, replaced}));
    }
  }
  return row.back();
}

std::string similar_option(std::string argument, std::span<const std::string> names) {
  constexpr std::size_t kLongest = 40;  // of an argument that may be a name
  if (!argument.starts_with('-')) return {};
  argument = argument.substr(0, argument.find('='));
  argument.erase(0, argument.find_first_not_of('-'));
  std::ranges::replace(argument, '_', '-');
  if (argument.size() < 2 || argument.size() > kLongest) return {};
  const std::size_t most = argument.size() < 6 ? 1 : 2;
  std::size_t least = most + 1;
  std::string found;
  for (const std::string& name : names) {
    const bool begins = name.starts_with(argument) || argument.starts_with(name);
    const std::size_t edits = std::min(edit_distance(argument, name), begins ? most : kLongest);
    if (edits >= least) continue;
    least = edits;
    found = name;
  }
  return found;
}

}  // namespace palpate

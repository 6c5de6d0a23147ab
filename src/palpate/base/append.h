/// \file
/// Appends one vector to another.
#pragma once

#include <vector>

namespace palpate {

template <typename T>
void append(std::vector<T>& all, const std::vector<T>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

}  // namespace palpate

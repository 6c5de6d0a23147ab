/// \file
/// Progress callback of long operations.
#pragma once

#include <functional>
#include <string_view>

namespace palpate {

/// Called from time to time on the thread that does the work. `stage` names the current step ("reading"),
/// `fraction` is in [0, 1]. An empty function disables reporting.
using Progress = std::function<void(std::string_view stage, double fraction)>;

/// Calls `progress` unless it is empty.
inline void report(const Progress& progress, std::string_view stage, double fraction) {
  if (progress) progress(stage, fraction);
}

}  // namespace palpate

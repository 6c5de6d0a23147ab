/// \file
/// How long work tells its caller how far it is.
#pragma once

#include <functional>
#include <string_view>

namespace palpate {

/// Called now and then on the thread that does the work. `stage` names the work ("reading"),
/// `fraction` is in [0, 1]. An empty function means that nobody watches.
using Progress = std::function<void(std::string_view stage, double fraction)>;

/// Calls `progress` if there is one.
inline void report(const Progress& progress, std::string_view stage, double fraction) {
  if (progress) progress(stage, fraction);
}

}  // namespace palpate

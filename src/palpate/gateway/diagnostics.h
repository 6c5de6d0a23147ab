/// \file
/// State of a loop as a diagnostic status, whatever carries it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <palpate/servo/servo_loop.h>

namespace palpate {

/// What diagnostic_msgs/DiagnosticStatus holds; docs/gateway.md lists the values.
struct LiveDiagnostics {
  int level = 0;  ///< 0 fine, 1 held back by what passes by itself, 2 until a resume
  std::string_view message;
  std::vector<std::pair<std::string_view, std::string>> values;
};

/// Who looks on, and how fast the loop is.
struct DiagnosticContext {
  bool held = false;  ///< by a client
  double rate = 0.0;  ///< Unit: [Hz].
  std::size_t clients = 0;
};

LiveDiagnostics diagnose(const TickRecord& tick, const TickTimes& times, const LoopStatistics& statistics,
                         const DiagnosticContext& context);

}  // namespace palpate

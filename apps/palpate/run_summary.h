/// \file
/// What is told of a hand once `palpate run` is over.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <palpate/live/live_system.h>
#include <palpate/servo/live_view.h>

#include "output.h"

namespace palpate::cli {

/// A run of one hand that is over.
struct Outcome {
  double seconds;
  std::uint64_t ticks;
  LiveTotals totals;
  GovernorState state;              ///< before it was ended
  std::vector<std::string> faults;  ///< that there were, once each, in order
};

/// How it is before it is ended.
Outcome outcome_of(LiveSystem& system, const LiveView& view);

/// docs/columns.md has the fields, but for those of several hands.
Json to_json(const Outcome& outcome, LiveSystem& system);
void print_text(const Outcome& outcome, LiveSystem& system);

}  // namespace palpate::cli

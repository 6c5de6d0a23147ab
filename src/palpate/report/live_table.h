/// \file
/// What is told of a live loop that is over, as text and JSON.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <palpate/report/ordered_json.h>
#include <palpate/servo/live_view.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// A live loop that is over.
struct LiveOutcome {
  double seconds;
  std::uint64_t ticks;
  LiveTotals totals;
  GovernorState state;              ///< before it was ended
  std::vector<std::string> faults;  ///< that there were, once each, in order
};

/// The names of the faults that there were, once each, in order.
std::vector<std::string> faults_of(const LiveView& view);

/// docs/columns.md has the fields, but for those of several hands.
OrderedJson live_json(const LiveOutcome& outcome, const LoopStatistics& statistics);
std::string live_text(const LiveOutcome& outcome, const LoopStatistics& statistics);

}  // namespace palpate

/// \file
/// Summary of a finished live loop, as text and JSON.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <palpate/report/ordered_json.h>
#include <palpate/servo/live_view.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// Results of a finished live loop.
struct LiveOutcome {
  double seconds;
  std::uint64_t ticks;
  LiveTotals totals;
  GovernorState state;              ///< before the end was requested
  std::vector<std::string> faults;  ///< all that occurred, once each, in order
  std::uint64_t lost = 0;           ///< ticks that the recording lacks, if there is one
};

/// Returns the names of the faults that occurred, once each, in order.
std::vector<std::string> faults_of(const LiveView& view);

/// docs/columns.md lists the fields, except those of several hands.
OrderedJson live_json(const LiveOutcome& outcome, const LoopStatistics& statistics);
std::string live_text(const LiveOutcome& outcome, const LoopStatistics& statistics);

}  // namespace palpate

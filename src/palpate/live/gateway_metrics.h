/// \file
/// Prometheus counters and gauges of hands. Internal to live/.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include <palpate/gateway/tick_feed.h>

namespace palpate {

/// Data of one hand to be exported.
struct MetricsOfHand {
  std::string hand;  ///< label; empty: none
  TickFeed::Tick tick;
  const LoopStatistics& statistics;
};

/// Returns the metrics in the Prometheus text format, without the final newline. \param clients number of
/// WebSocket clients
std::string metrics_text(std::span<const MetricsOfHand> hands, std::size_t clients);

}  // namespace palpate

/// \file
/// Counters and gauges of hands, for Prometheus. Internal to live/.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include <palpate/gateway/tick_feed.h>

namespace palpate {

/// What is told of a hand.
struct MetricsOfHand {
  std::string hand;  ///< as label; empty: none
  TickFeed::Tick tick;
  const LoopStatistics& statistics;
};

/// In the text format of Prometheus, without the end of the last line. \param clients WebSockets
std::string metrics_text(std::span<const MetricsOfHand> hands, std::size_t clients);

}  // namespace palpate

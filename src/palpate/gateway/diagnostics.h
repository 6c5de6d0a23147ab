/// \file
/// Diagnostic status of a servo loop, independent of the transport.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <palpate/servo/servo_loop.h>
#include <palpate/servo/time_histogram.h>

namespace palpate {

/// Contents of a diagnostic_msgs/DiagnosticStatus; docs/gateway.md lists the values.
struct LiveDiagnostics {
  int level = 0;  ///< 0 = OK, 1 = temporary limitation that clears by itself, 2 = fault until a resume
  std::string_view message;
  std::vector<std::pair<std::string_view, std::string>> values;
};

/// Measures the rate of a loop and the durations of its ticks over windows of about a second. One thread.
class RateWatch {
 public:
  /// `statistics` must outlive it.
  explicit RateWatch(const LoopStatistics& statistics) : statistics_(statistics) {}

  /// Starts a new window if a second has passed. \param now on the loop's clock. Unit: [s].
  void update(double now);
  /// Returns the rate over the last window; 0 before the first update(). Unit: [Hz].
  double rate() const { return rate_; }
  /// Returns the tick durations of the same window.
  const TimeWindow& times() const { return times_; }

 private:
  const LoopStatistics& statistics_;
  TimeWindow times_{statistics_.whole};
  std::uint64_t ticks_ = 0;
  double at_ = 0.0, rate_ = 0.0;
};

/// State of the gateway's clients.
struct DiagnosticContext {
  bool held = false;  ///< a client holds the hand
  std::size_t clients = 0;
};

LiveDiagnostics diagnose(const TickRecord& tick, const TickTimes& times, const RateWatch& watch,
                         const DiagnosticContext& context);

}  // namespace palpate

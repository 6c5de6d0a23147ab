/// \file
/// State of a loop as a diagnostic status, whatever carries it.
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

/// What diagnostic_msgs/DiagnosticStatus holds; docs/gateway.md lists the values.
struct LiveDiagnostics {
  int level = 0;  ///< 0 fine, 1 held back by what passes by itself, 2 until a resume
  std::string_view message;
  std::vector<std::pair<std::string_view, std::string>> values;
};

/// How fast a loop is, and how long its ticks take: over about a second. One thread.
class RateWatch {
 public:
  /// `statistics` must outlive it.
  explicit RateWatch(const LoopStatistics& statistics) : statistics_(statistics) {}

  /// Begins a new second if one has passed. \param now of the loop's clock. Unit: [s].
  void look(double now);
  /// Of the last second; 0 before the first look. Unit: [Hz].
  double rate() const { return rate_; }
  /// Of the same ticks.
  const TimeWindow& times() const { return times_; }

 private:
  const LoopStatistics& statistics_;
  TimeWindow times_{statistics_.whole};
  std::uint64_t ticks_ = 0;
  double at_ = 0.0, rate_ = 0.0;
};

/// Who looks on.
struct DiagnosticContext {
  bool held = false;  ///< by a client
  std::size_t clients = 0;
};

LiveDiagnostics diagnose(const TickRecord& tick, const TickTimes& times, const RateWatch& watch,
                         const DiagnosticContext& context);

}  // namespace palpate

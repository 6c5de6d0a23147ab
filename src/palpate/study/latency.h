/// \file
/// Stopwatch and latency statistics, for `palpate bench` and the benchmarks.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

namespace palpate {

class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  double microseconds() const { return 1e6 * seconds(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

/// Times of a set of queries; all zero if there are none. Unit: [us].
struct Latency {
  std::size_t count = 0;
  double median = 0.0, p99 = 0.0, p999 = 0.0, max = 0.0, mean = 0.0;

  explicit Latency(std::vector<double> times);
};

/// A time with three significant digits. Unit: [us].
std::string microseconds(double us);

}  // namespace palpate

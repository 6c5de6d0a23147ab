#include <palpate/study/latency.h>

#include <numeric>

#include <fmt/core.h>

#include <palpate/base/quantile.h>

namespace palpate {

Latency::Latency(std::vector<double> times) : count(times.size()) {
  if (times.empty()) return;
  median = quantile(times, 0.5);
  p99 = quantile(times, 0.99);
  p999 = quantile(times, 0.999);
  max = quantile(times, 1.0);
  mean = std::accumulate(times.begin(), times.end(), 0.0) / static_cast<double>(count);
}

std::string microseconds(double us) {
  return us >= 100.0 ? fmt::format("{:.0f} us", us) : fmt::format("{:.3g} us", us);
}

}  // namespace palpate

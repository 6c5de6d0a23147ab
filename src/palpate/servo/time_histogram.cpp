#include <palpate/servo/time_histogram.h>

#include <algorithm>
#include <cmath>

namespace palpate {

void TimeHistogram::add(double seconds) {
  const double place = kPerOctave * std::log2(std::max(seconds, kFirst) / kFirst);
  const auto k = std::min(static_cast<std::size_t>(place), kClasses - 1);
  classes_[k].fetch_add(1, std::memory_order_relaxed);
  count_.fetch_add(1, std::memory_order_relaxed);
  if (seconds > max()) max_.store(seconds, std::memory_order_relaxed);  // there is one writer
}

double TimeHistogram::quantile(double q) const {
  if (q >= 1.0) return max();
  const auto rank = static_cast<std::uint64_t>(q * static_cast<double>(count()));
  std::uint64_t below = 0;
  for (std::size_t k = 0; k < kClasses; ++k) {
    below += classes_[k].load(std::memory_order_relaxed);
    if (below > rank) return std::min(max(), kFirst * std::exp2((static_cast<double>(k) + 0.5) / kPerOctave));
  }
  return max();
}

}  // namespace palpate

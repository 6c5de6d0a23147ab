#include <palpate/servo/time_histogram.h>

#include <algorithm>
#include <cmath>

namespace palpate {

void TimeHistogram::add(double seconds) {
  const double place = kPerOctave * std::log2(std::max(seconds, kFirst) / kFirst);
  const auto k = std::min(static_cast<std::size_t>(place), kClasses - 1);
  classes_[k].fetch_add(1, std::memory_order_relaxed);
  count_.fetch_add(1, std::memory_order_relaxed);
  if (seconds > max()) max_.store(seconds, std::memory_order_relaxed);  // single writer
}

double TimeHistogram::quantile(double q) const {
  if (q >= 1.0) return max();
  const auto rank = static_cast<std::uint64_t>(q * static_cast<double>(count()));
  std::uint64_t below = 0;
  for (std::size_t k = 0; k < kClasses; ++k) {
    below += classes_[k].load(std::memory_order_relaxed);
    if (below > rank) return std::min(max(), middle(k));
  }
  return max();
}

double TimeHistogram::middle(std::size_t k) {
  return kFirst * std::exp2((static_cast<double>(k) + 0.5) / kPerOctave);
}

void TimeWindow::next() {
  count_ = 0;
  for (std::size_t k = 0; k < counts_.size(); ++k) {
    const std::uint64_t now = of_.classes_[k].load(std::memory_order_relaxed);
    counts_[k] = now - seen_[k];
    seen_[k] = now;
    count_ += counts_[k];
  }
}

double TimeWindow::mean() const {
  double sum = 0.0;
  for (std::size_t k = 0; k < counts_.size(); ++k)
    sum += static_cast<double>(counts_[k]) * TimeHistogram::middle(k);
  return count_ > 0 ? sum / static_cast<double>(count_) : 0.0;
}

double TimeWindow::quantile(double q) const {
  const double rank = q * static_cast<double>(count_);
  std::uint64_t below = 0;
  for (std::size_t k = 0; k < counts_.size(); ++k) {
    below += counts_[k];
    if (counts_[k] > 0 && static_cast<double>(below) >= rank) return TimeHistogram::middle(k);
  }
  return 0.0;
}

}  // namespace palpate

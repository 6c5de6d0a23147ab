#include <palpate/gateway/stamp_clock.h>

#include <algorithm>
#include <cmath>

namespace palpate {

void StampClock::reset() {
  echoes_ = {};
  least_.fill(std::numeric_limits<double>::infinity());
}

double StampClock::least_offset() const { return *std::min_element(least_.begin(), least_.end()); }

std::optional<double> StampClock::age(double stamp, double now) {
  if (const std::optional<double> echoed = echoes_.age(stamp, now)) {
    if (*echoed < -kFuture) return std::nullopt;
    return std::max(0.0, *echoed);
  }
  const auto second = static_cast<std::int64_t>(std::floor(now));
  const std::int64_t passed = std::min<std::int64_t>(second - second_, kSeconds);
  for (std::int64_t k = 0; k < passed; ++k)
    least_[static_cast<std::size_t>((second - k) % kSeconds)] = std::numeric_limits<double>::infinity();
  second_ = second;
  const double offset = now - stamp, known = least_offset();
  if (offset < known - kFuture && std::isfinite(known)) return std::nullopt;
  double& least = least_[static_cast<std::size_t>(second % kSeconds)];
  least = std::min(least, offset);
  return offset - std::min(known, offset) + 2.0 * one_way_;
}

}  // namespace palpate

#include <palpate/gateway/client_clock.h>

#include <algorithm>
#include <cmath>

namespace palpate {

std::uint64_t ClientClock::ask(double t) {
  ++count_;
  echoes_[count_ % kKept] = {count_, t};
  return count_;
}

void ClientClock::answer(std::uint64_t number, double stamp, double t) {
  Echo& echo = echoes_[number % kKept];
  if (number == 0 || echo.number != number || std::isfinite(echo.round_trip)) return;
  echo.stamp = stamp;
  echo.round_trip = t - echo.asked;
  best_ = *std::min_element(echoes_.begin(), echoes_.end(),
                            [](const Echo& a, const Echo& b) { return a.round_trip < b.round_trip; });
}

std::optional<double> ClientClock::age(double stamp, double t) const {
  if (!std::isfinite(best_.round_trip) || t - best_.asked > kGood) return std::nullopt;
  return (t - best_.asked) - (stamp - best_.stamp);
}

}  // namespace palpate

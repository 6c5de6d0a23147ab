#include <palpate/gateway/client_hand.h>

#include <cmath>

#include <palpate/geometry/rotation.h>

namespace palpate {

std::uint64_t ClientHand::put(const DevicePose& pose, double t) {
  samples_.back() = {pose, t, ++count_, hand_};
  samples_.publish();
  held_.store(true, std::memory_order_relaxed);
  arrived_.set();
  return count_;
}

const ClientHand::Sample& ClientHand::newest() {
  if (samples_.update()) seen_.store(samples_.front().number, std::memory_order_release);
  return samples_.front();
}

bool ClientDevice::read(double, DeviceReading& reading) {
  const ClientHand::Sample& sample = hand_.newest();
  if (sample.number == read_) return false;
  if (sample.hand != last_.hand) last_.velocity = {};
  const double dt = sample.hand == last_.hand ? sample.t - last_.t : 0.0;
  if (read_ != 0 && dt > 0.0) {
    const double share = -std::expm1(-dt / kVelocityFilter);
    last_.velocity.linear +=
        share * ((sample.pose.position - last_.pose.position) / dt - last_.velocity.linear);
    last_.velocity.angular +=
        share * (turn_between(last_.pose.orientation, sample.pose.orientation) / dt - last_.velocity.angular);
  }
  read_ = sample.number;
  last_.pose = sample.pose;
  last_.t = sample.t;
  last_.hand = sample.hand;
  reading = last_;
  return true;
}

void ClientDevice::wait(const LoopClock& clock, double until) {
  const double earliest = ticked_ + kLeastPeriod;
  if (clock.now() < earliest && earliest < until) clock.sleep_until(earliest);
  if (const double left = until - clock.now(); left > 0.0) hand_.wait(left);
  ticked_ = clock.now();
}

}  // namespace palpate

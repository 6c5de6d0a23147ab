#include <palpate/servo/motion_governor.h>

#include <algorithm>
#include <cmath>

#include <palpate/geometry/rotation.h>

namespace palpate {
namespace {

bool finite(const Twist& v) { return v.linear.allFinite() && v.angular.allFinite(); }

double way(const DevicePose& a, const DevicePose& b) { return (b.position - a.position).norm(); }
double turn(const DevicePose& a, const DevicePose& b) {
  return turn_between(a.orientation, b.orientation).norm();
}

}  // namespace

MotionSafety MotionSafety::of(const DeviceCapabilities& device, const MotionLimits& limits, double tick) {
  constexpr double kAbove = 1.5, kMissed = 3.0;
  MotionSafety safety;
  safety.tick = tick;
  safety.reading_period = 1.0 / device.rate;
  safety.stale_after = std::max(safety.stale_after, kMissed * safety.reading_period);
  safety.late_max = std::max(safety.late_max, kMissed * tick);
  const double diagonal = std::sqrt(3.0);  // limits are those of each axis
  safety.speed_max = kAbove * diagonal * limits.velocity;
  safety.angular_speed_max = kAbove * diagonal * limits.angular_velocity;
  safety.sensor.force_range = device.force_max;
  safety.sensor.torque_range = device.torque_max;
  return safety;
}

MotionGovernor::MotionGovernor(const MotionSafety& safety) : safety_(safety), sensor_(safety.sensor) {}

void MotionGovernor::begin_tick(double t) {
  passed_ = begun_ ? std::max(0.0, t - t_) : 0.0;
  t_ = t;
  if (!begun_) {
    begun_ = true;
    arrived_ = small_since_ = since_ = t;
  }
  if (lateness_.exceeds(safety_.late_max, passed_, safety_.tick)) raise(Fault::kLateTick);
  hear();
}

void MotionGovernor::hear() {
  const unsigned asked = stop_asked_.exchange(0, std::memory_order_relaxed);
  for (unsigned fault = 1; fault < kFaultCount; ++fault)
    if ((asked >> fault & 1U) != 0U) raise(static_cast<Fault>(fault));
  if (resume_asked_.exchange(false, std::memory_order_relaxed)) held_ &= asked;
  if (unpause_asked_.exchange(false, std::memory_order_relaxed)) held_ &= ~fault_bit(Fault::kPaused) | asked;
  if (tare_asked_.exchange(false, std::memory_order_relaxed)) {
    tared_ = false;
    raise(Fault::kChanging);
  }
}

Fault MotionGovernor::check(const MotionReading& reading) const {
  if (!started_) return Fault::kNone;
  if (reading.hand != newest_.hand) return Fault::kChanging;
  const double dt = std::clamp(reading.t - newest_.t, safety_.reading_period, safety_.stale_after);
  if (way(newest_.pose, reading.pose) > safety_.jump + safety_.speed_max * dt ||
      turn(newest_.pose, reading.pose) > safety_.angular_jump + safety_.angular_speed_max * dt)
    return Fault::kJump;
  const bool quick = reading.velocity.linear.norm() > safety_.speed_max ||
                     reading.velocity.angular.norm() > safety_.angular_speed_max;
  return quick ? Fault::kOverSpeed : Fault::kNone;
}

void MotionGovernor::listen_to_sensor(const MotionReading& reading) {
  const SensorFault found = sensor_.take(reading.user, reading.user_t, t_);
  heard_sensor_ = heard_sensor_ || found == SensorFault::kNone;
  if (found == SensorFault::kNone) return;
  sensor_fault_ = found;
  raise(Fault::kForceSensor);
}

void MotionGovernor::admit_none(double t) {
  begin_tick(t);
  if (t - arrived_ > safety_.stale_after) raise(Fault::kStalePose);
  advance();
}

void MotionGovernor::admit(const MotionReading& said, double t) {
  begin_tick(t);
  const bool good = std::isfinite(said.t) && said.pose.is_valid() && finite(said.velocity);
  if (!good) raise(Fault::kBadPose);
  const bool fresh = good && said.t <= t + safety_.stale_after && (!started_ || said.t > newest_.t);
  if (!fresh && t - arrived_ > safety_.stale_after) raise(Fault::kStalePose);
  listen_to_sensor(said);
  if (fresh) {
    MotionReading reading = said;
    reading.pose.orientation.normalize();
    const Fault found = check(reading);
    moves_on_ = found != Fault::kJump;
    if ((found == Fault::kJump || (started_ && reading.hand != newest_.hand)) && !jumped_) {
      jumped_ = true;
      jumped_at_ = t;
    }
    newest_ = reading;
    arrived_ = t;
    started_ = true;
    if (found == Fault::kNone || found == Fault::kChanging) reading_ = reading;
    if (found != Fault::kNone) raise(found);
  }
  advance();
}

bool MotionGovernor::small() const {
  if (!started_ || !heard_sensor_) return false;
  const Wrench hand = user();
  if (tared_) return hand.force.norm() <= safety_.gate_force && hand.torque.norm() <= safety_.gate_torque;
  return hand.force.norm() <= safety_.sensor.bias_force && hand.torque.norm() <= safety_.sensor.bias_torque;
}

void MotionGovernor::advance() {
  if (!small() || state_ != GovernorState::kWaiting) {
    small_since_ = t_;
    sensor_.begin_tare();
  }
  switch (state_) {
    case GovernorState::kWaiting:
      if (t_ - small_since_ < safety_.gate_time) break;
      if (!tared_) tared_ = sensor_.tare() == SensorFault::kNone;
      if (tared_) enter(GovernorState::kRising);
      break;
    case GovernorState::kRising:
      if (t_ - since_ >= safety_.rise_time) enter(GovernorState::kActive);
      break;
    case GovernorState::kFalling:
      if (at_rest_) enter(GovernorState::kStopped);
      break;
    case GovernorState::kStopped:
      if (held_ == 0U && t_ - wrong_at_ >= safety_.recover_after) {
        fault_ = Fault::kNone;
        jumped_ = elsewhere_ = false;  // readings have been consistent since recover_after
        enter(GovernorState::kWaiting);
      }
      break;
    case GovernorState::kActive: break;
  }
}

double MotionGovernor::share() const {
  if (state_ == GovernorState::kActive) return 1.0;
  if (state_ == GovernorState::kRising) return std::min(1.0, (t_ - since_) / safety_.rise_time);
  return 0.0;
}

bool MotionGovernor::moved(const MotionSetpoint& wanted, const MotionSetpoint& followed, bool at_rest) {
  const bool good = wanted.pose.is_valid() && finite(wanted.velocity) && finite(wanted.acceleration);
  if (!good) raise(Fault::kBadForce);
  at_rest_ = at_rest;
  if (elsewhere_) return good;
  // An old reading does not tell how a motion is followed that went on without it.
  const bool current = started_ && arrived_ == t_ && moves_on_;
  elsewhere_ = jumped_ && !current && t_ - jumped_at_ > safety_.stale_after;
  if (!current) return good;
  const bool far = way(followed.pose, newest_.pose) > safety_.following_max ||
                   turn(followed.pose, newest_.pose) > safety_.angular_following_max;
  if (far && jumped_)
    elsewhere_ = true;
  else if (far)
    raise(Fault::kNotFollowing);
  jumped_ = false;
  return good;
}

/// The first fault is reported, unless a later one latches.
void MotionGovernor::raise(Fault fault) {
  wrong_at_ = t_;
  const bool down = state_ == GovernorState::kFalling || state_ == GovernorState::kStopped;
  const bool graver = !down || (traits(fault).latched && (held_ == 0U || fault == Fault::kEmergencyStop));
  if (traits(fault).latched) held_ |= fault_bit(fault);
  if (graver) fault_ = fault;
  if (!down) enter(GovernorState::kFalling);
}

void MotionGovernor::enter(GovernorState state) {
  state_ = state;
  since_ = t_;
  if (remembered_ == transitions_.size()) {
    std::move(transitions_.begin() + 1, transitions_.end(), transitions_.begin());
    --remembered_;
  }
  transitions_[remembered_++] = {t_, state_, fault_};
}

}  // namespace palpate

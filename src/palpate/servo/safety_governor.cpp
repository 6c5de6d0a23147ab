#include <palpate/servo/safety_governor.h>

#include <algorithm>
#include <cmath>

#include <palpate/geometry/rotation.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

/// Factor on every bound, so that rounding does not exceed it.
constexpr double kBelow = 1.0 - 1e-12;
/// Time constant of the measured rate of readings. Unit: [s].
constexpr double kRateFilter = 0.25;

bool is_finite(const Wrench& w) { return w.force.allFinite() && w.torque.allFinite(); }

bool is_valid(const DeviceReading& r) {
  return std::isfinite(r.t) && r.pose.is_valid() && r.velocity.linear.allFinite() &&
         r.velocity.angular.allFinite();
}

bool same(const DevicePose& a, const DevicePose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

/// `v` shortened to at most `longest`. Correct for every finite v, even if its norm is not finite.
Vector3d shortened(const Vector3d& v, double longest) {
  const double scale = v.cwiseAbs().maxCoeff();
  if (scale == 0.0) return v;
  const Vector3d u = v / scale;
  const double norm = u.norm();
  return scale * norm > longest ? Vector3d(u * (longest / norm)) : v;
}

Wrench shortened(const Wrench& w, double force, double torque) {
  return {shortened(w.force, force * kBelow), shortened(w.torque, torque * kBelow)};
}

Wrench operator*(double share, const Wrench& w) { return {share * w.force, share * w.torque}; }
Wrench operator+(const Wrench& a, const Wrench& b) { return {a.force + b.force, a.torque + b.torque}; }
Wrench operator-(const Wrench& a, const Wrench& b) { return {a.force - b.force, a.torque - b.torque}; }
bool is_zero(const Wrench& w) { return w.force.isZero(0.0) && w.torque.isZero(0.0); }

/// Rank that decides which of two faults is reported.
int gravity(Fault fault) {
  if (!traits(fault).latched) return 0;
  if (traits(fault).requested) return 1;
  return fault == Fault::kEmergencyStop ? 3 : 2;
}

/// Number of crossings of the workspace in energy_reserve.
constexpr double kThereAndBack = 2.0;

}  // namespace

SafetyLimits SafetyLimits::of(const DeviceCapabilities& device, double tick) {
  SafetyLimits limits;
  limits.force_max = device.force_max;
  limits.torque_max = device.torque_max;
  limits.force_sustained = device.force_sustained;
  limits.torque_sustained = device.torque_sustained;
  limits.force_slew = device.force_max / kSlewTime;
  limits.torque_slew = device.torque_max / kSlewTime;
  const double width = 2.0 * device.workspace;
  limits.energy_reserve = std::max(limits.energy_reserve, kThereAndBack * width * device.force_max);
  limits.tick = tick;
  limits.reading_period = 1.0 / device.rate;
  constexpr double kMissed = 3.0;  // consecutive readings or ticks: fewer are merely late
  limits.stale_after = std::max(limits.stale_after, kMissed * limits.reading_period);
  limits.late_max = std::max(limits.late_max, kMissed * tick);
  return limits;
}

std::string_view to_string(GovernorState state) {
  constexpr std::array<std::string_view, 5> kNames{"waiting", "rising", "active", "falling", "stopped"};
  return kNames[static_cast<std::size_t>(state)];
}

bool SafetyGovernor::SpeedBound::take(double way, double dt, double period) {
  left = std::min(left + speed * dt, noise + speed * std::max(dt, period));
  const bool has = way <= left;  // false for NaN
  left = has ? left - way : 0.0;
  return has;
}

SafetyGovernor::SafetyGovernor(const SafetyLimits& limits)
    : limits_(limits),
      jump_{limits.jump_speed, limits.noise, limits.noise},
      quick_{limits.speed_max, limits.noise, limits.noise},
      angular_jump_{limits.jump_angular_speed, limits.angular_noise, limits.angular_noise},
      angular_quick_{limits.angular_speed_max, limits.angular_noise, limits.angular_noise},
      force_(limits.force_max, limits.force_sustained),
      torque_(limits.torque_max, limits.torque_sustained) {}

Fault SafetyGovernor::check(const DeviceReading& reading) {
  if (!started_) return Fault::kNone;
  if (reading.hand != newest_.hand) return Fault::kChanging;  // not a jump
  const double dt = std::min(reading.t - newest_.t, limits_.stale_after), period = limits_.reading_period;
  const double way = (reading.pose.position - newest_.pose.position).norm();
  const double turn = turn_between(newest_.pose.orientation, reading.pose.orientation).norm();
  const bool there = jump_.take(way, dt, period), turned = angular_jump_.take(turn, dt, period);
  const bool slow = quick_.take(way, dt, period), calm = angular_quick_.take(turn, dt, period);
  if (!there || !turned) return Fault::kJump;
  const bool quick = !slow || !calm || reading.velocity.linear.norm() > limits_.speed_max ||
                     reading.velocity.angular.norm() > limits_.angular_speed_max;
  return quick ? Fault::kOverSpeed : Fault::kNone;
}

void SafetyGovernor::begin_tick(double t) {
  passed_ = begun_ ? std::max(0.0, t - t_) : 0.0;
  t_ = t;
  if (!begun_) {
    begun_ = true;
    arrived_ = moved_ = small_since_ = since_ = t;
  }
  force_.pass(sent_.force.norm(), passed_);
  torque_.pass(sent_.torque.norm(), passed_);
  if (lateness_.exceeds(limits_.late_max, passed_, limits_.tick)) raise(Fault::kLateTick);
  hear();
}

void SafetyGovernor::admit_none(double t) {
  begin_tick(t);
  if (t - arrived_ > limits_.stale_after) raise(Fault::kStalePose);
}

bool SafetyGovernor::admit(const DeviceReading& said, double t) {
  begin_tick(t);
  const bool good = is_valid(said);
  if (!good) raise(Fault::kBadPose);
  // Readings from the future are rejected: a device whose clock runs fast would otherwise never be stale.
  const bool fresh = good && said.t <= t + limits_.stale_after && (!started_ || said.t > newest_.t);
  watch_rate(fresh);
  DeviceReading reading = said;
  if (good) reading.pose.orientation.normalize();
  watch_stillness(fresh && (!started_ || !same(reading.pose, newest_.pose)));
  if (!fresh) {
    if (t - arrived_ > limits_.stale_after) raise(Fault::kStalePose);
    return false;
  }
  const Fault found = check(reading);
  if (started_ && found != Fault::kJump && found != Fault::kChanging)
    watch_energy(newest_.pose, reading.pose, std::min(reading.t - newest_.t, limits_.stale_after));
  newest_ = reading;
  arrived_ = t;
  started_ = true;
  if (found != Fault::kNone) {
    raise(found);
    return false;
  }
  reading_ = reading;
  asked_ = true;
  return true;
}

/// Handles the requests of other threads.
void SafetyGovernor::hear() {
  const unsigned asked = stop_asked_.exchange(0, std::memory_order_relaxed);
  for (unsigned fault = 1; fault < kFaultCount; ++fault)
    if ((asked >> fault & 1U) != 0U) raise(static_cast<Fault>(fault));
  const bool resumes = resume_asked_.exchange(false, std::memory_order_relaxed);
  const bool unpauses = unpause_asked_.exchange(false, std::memory_order_relaxed);
  if (resumes) forgive(held_ & ~asked);
  if (unpauses) forgive(fault_bit(Fault::kPaused) & ~asked);
}

void SafetyGovernor::forgive(unsigned faults) {
  held_ &= ~faults;
  if (holds(fault_)) return;
  // The reported fault has ended; another may not have.
  for (unsigned k = 1; k < kFaultCount; ++k) {
    const auto fault = static_cast<Fault>(k);
    if ((held_ & fault_bit(fault)) != 0U && (!holds(fault_) || gravity(fault) > gravity(fault_)))
      fault_ = fault;
  }
  if (holds(fault_)) remember();
}

/// A fault that does not latch holds until the governor returns to waiting.
bool SafetyGovernor::holds(Fault fault) const {
  return !traits(fault).latched || (held_ & fault_bit(fault)) != 0U;
}

/// Exact except for the delay of the device, since the force was held from one reading to the next.
void SafetyGovernor::watch_energy(const DevicePose& from, const DevicePose& to, double dt) {
  energy_ = std::max(0.0, energy_ - limits_.energy_leak * dt) + std::min(0.0, energy_);
  energy_ += sent_.force.dot(to.position - from.position) +
             sent_.torque.dot(turn_between(from.orientation, to.orientation));
  reach_.extend(to.position);  // a simulated hand moves beyond the workspace of any device
  const double width = reach_.diagonal().norm();
  energy_ = std::max(energy_, -std::max(limits_.energy_reserve, kThereAndBack * width * limits_.force_max));
  if (energy_ > limits_.energy_max) {
    raise(Fault::kOverEnergy);
    energy_ = 0.0;
  }
}

/// A reading counts for the nominal period until the next one or, in a loop slower than the device, for the
/// tick.
void SafetyGovernor::watch_rate(bool fresh) {
  const double spoken_for = fresh ? std::max(limits_.reading_period, passed_) : 0.0;
  fresh_ = std::min(1.0, fresh_ * std::exp(-passed_ / kRateFilter) + spoken_for / kRateFilter);
  if (fresh_ < 0.5) raise(Fault::kSlowDevice);
}

/// Broken encoders do not report themselves. A handle held by friction moves once the force on it decreases.
void SafetyGovernor::watch_stillness(bool moved) {
  if (moved || !presses_) moved_ = t_;
  const bool still = t_ - moved_ > limits_.frozen_after;
  fade_ = std::clamp(fade_ + (still ? -passed_ / limits_.fade_time : passed_ / limits_.rise_time), 0.0, 1.0);
  if (fade_ == 0.0) raise(Fault::kFrozenPose);
}

void SafetyGovernor::enter(GovernorState state) {
  state_ = state;
  asked_ = false;
  since_ = t_;
  remember();
}

void SafetyGovernor::remember() {
  if (remembered_ == kRemembered) {
    std::move(transitions_.begin() + 1, transitions_.end(), transitions_.begin());
    --remembered_;
  }
  transitions_[remembered_++] = {t_, state_, fault_};
  ++transition_count_;
}

/// The first fault is reported as the reason, unless a later one is graver; the one with the shortest fall
/// time sets the ramp.
void SafetyGovernor::raise(Fault fault) {
  wrong_at_ = t_;
  const bool down = state_ == GovernorState::kFalling || state_ == GovernorState::kStopped;
  const bool told = down && holds(fault_) && gravity(fault) <= gravity(fault_);
  if (traits(fault).latched) held_ |= fault_bit(fault);
  const double end = t_ + traits(fault).fall_time;
  if (!down || end < fall_end_) {
    at_fall_ = sent_;
    fall_from_ = t_;
    fall_end_ = end;
  }
  if (told) return;
  fault_ = fault;
  down ? remember() : enter(GovernorState::kFalling);
}

void SafetyGovernor::advance(bool small) {
  if (!small || !asked_) small_since_ = t_;  // before it is asked for, nobody knows how large it is
  const double passed = t_ - since_;
  switch (state_) {
    case GovernorState::kWaiting:
      if (std::min(passed, t_ - small_since_) >= limits_.gate_time) enter(GovernorState::kRising);
      break;
    case GovernorState::kRising:
      if (passed >= limits_.rise_time) enter(GovernorState::kActive);
      break;
    case GovernorState::kFalling:
      if (is_zero(sent_) && t_ - fall_from_ >= fall_end_ - fall_from_) enter(GovernorState::kStopped);
      break;
    case GovernorState::kStopped:
      if (held_ == 0U && t_ - wrong_at_ >= limits_.recover_after) {
        fault_ = Fault::kNone;
        enter(GovernorState::kWaiting);
      }
      break;
    case GovernorState::kActive: break;
  }
}

/// Fraction of the requested force or, while falling, of the last force before the fall.
double SafetyGovernor::share() const {
  const double passed = t_ - since_;
  switch (state_) {
    case GovernorState::kRising: return fade_ * std::min(1.0, passed / limits_.rise_time);
    case GovernorState::kActive: return fade_;
    // Evaluated one tick ahead, so that the force is zero in time.
    case GovernorState::kFalling:
      if (fall_end_ <= fall_from_) return 0.0;
      return std::max(0.0, 1.0 - (t_ + limits_.tick - fall_from_) / (fall_end_ - fall_from_));
    default: return 0.0;
  }
}

Wrench SafetyGovernor::release(const Wrench& wanted, double contacts_age, bool is_known) {
  if (stop_asked_.load(std::memory_order_relaxed) != 0U) hear();  // requests made while the model ran
  const bool good = is_finite(wanted);
  if (!good) raise(Fault::kBadForce);
  if (!(contacts_age <= limits_.contacts_after)) raise(Fault::kLateContacts);
  const Wrench asked = good ? shortened(wanted, limits_.force_max, limits_.torque_max) : Wrench{};
  const bool small = is_known && asked.force.norm() <= limits_.gate_share * limits_.force_max &&
                     asked.torque.norm() <= limits_.gate_share * limits_.torque_max;
  advance(small);
  presses_ = !small && (state_ == GovernorState::kRising || state_ == GovernorState::kActive);
  if (state_ == GovernorState::kFalling) {  // on its own ramp, however late the tick
    sent_ = share() * at_fall_;
    force_scale_ = 0.0;
    return sent_;
  }
  const double time = std::min(passed_, Lateness::kOnTime * limits_.tick);  // what the slew limit counts
  const Wrench bearable = shortened(asked, force_.bound(), torque_.bound());
  const double force = wanted.force.norm();
  force_scale_ = good ? share() * (force > 0.0 ? std::min(1.0, bearable.force.norm() / force) : 1.0) : 0.0;
  sent_ =
      sent_ + shortened(share() * bearable - sent_, limits_.force_slew * time, limits_.torque_slew * time);
  return sent_;
}

}  // namespace palpate

#include <palpate/servo/servo_tick.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <palpate/geometry/rotation.h>

namespace palpate {
namespace {

/// Time constant of the gain: a hand that leans on a surface feels it yield, and does not fall. Unit: [s].
constexpr double kGainFilter = 0.1;
/// Time constant of the mean hold time of forces: longer than an occasional late tick. Unit: [s].
constexpr double kHeldFilter = 0.5;
/// A hold time that falls by less is the same: a stiffness that follows every late tick moves the hand.
constexpr double kSameHold = 0.1;
/// Prevents division by zero.
constexpr double kLeastGain = 1e-6;

/// The fraction of a wrench that a device can render; 1 for one that is not finite, which the governor
/// handles.
double share_shown(const Wrench& wrench, const DeviceCapabilities& device) {
  const auto share = [](double most, double asked) { return asked > most ? most / asked : 1.0; };
  const double rho = std::min(share(device.force_max, wrench.force.norm()),
                              device.torque_max > 0.0 ? share(device.torque_max, wrench.torque.norm()) : 1.0);
  return rho > 0.0 ? rho : 1.0;
}

/// Radius that converts the damping that is added to one about axes: both take the same share of the peak
/// and, where a controller is the damper, of what that has. Unit: [m].
double arm_of(const DeviceCapabilities& device) {
  const double of_motors = device.torque_max / device.force_max;
  if (device.kind == Causality::kImpedance) return of_motors;
  return std::min(of_motors, std::sqrt(device.angular_damping / device.damping));
}

}  // namespace

ServoTick::ServoTick(HapticDevice& device, FeltModel model, const ServoTickOptions& options)
    : device_(device),
      used_(model),
      map_(options.map),
      gain_(options.gain),
      passive_gain_(options.gain),
      governor_(options.limits.value_or(SafetyLimits::of(device.capabilities(), options.period))),
      passivity_(1.0 / device.capabilities().rate, device.capabilities().damping,
                 device.capabilities().damping_max, arm_of(device.capabilities()),
                 device.capabilities().torque_max > 0.0 ? device.capabilities().angular_damping : 0.0),
      keeps_passive_(options.keeps_passive),
      held_for_(std::max(options.period, 1.0 / device.capabilities().rate)),
      counted_hold_(held_for_),
      wanted_gain_(options.gain) {
  found_.contacts.reserve(ToolTracker::kRoom);
}

void ServoTick::use(const FeltModel& model) {
  next_.back() = {model, ++given_};
  next_.publish();
}

void ServoTick::set_gain(double gain) {
  if (std::isfinite(gain) && gain >= 0.0) wanted_gain_.store(gain, std::memory_order_relaxed);
}

void ServoTick::press_clutch(bool pressed) { clutch_pressed_.store(pressed, std::memory_order_relaxed); }

void ServoTick::bring(const Pose& place, double reach) {
  places_.back() = {place, reach};
  places_.publish();
}

/// Applies changes requested by other threads. Those that make the force or the tool's path jump go through
/// the start gate. \param passed since the last tick. Unit: [s].
void ServoTick::change(double passed) {
  const double gain = std::min(wanted_gain_.load(std::memory_order_relaxed), gain_max_);
  gain_ += -std::expm1(-passed / kGainFilter) * (gain - gain_);
  changing_ = next_.update() || changing_;
  clutched_ = clutch_pressed_.load(std::memory_order_relaxed);
  brings_ = places_.update() || brings_;
  const Place& place = places_.front();
  if ((place.pose.position - record_.tool.position).norm() <= place.reach) brings_ = false;
  if (changing_ || clutched_ || brings_) governor_.stop(Fault::kChanging);
  if (governor_.state() == GovernorState::kStopped && brings_ && !clutched_ && !tool_held_) {
    map_.attach(place.pose, record_.reading.pose);
    brings_ = false;
  }
  if (governor_.state() == GovernorState::kStopped && changing_) {
    used_ = next_.front().model;
    gain_max_ = std::numeric_limits<double>::infinity();
    taken_.store(next_.front().number, std::memory_order_release);
    changing_ = false;
  }
}

void ServoTick::feel() {
  const DeviceReading& reading = record_.reading;
  const DeviceCapabilities& can = device_.capabilities();
  const double passed = asked_ ? reading.t - asked_at_ : 0.0;
  // Largest force in the world that the device renders at this gain, and largest damping.
  const double least = std::max(gain_, kLeastGain);
  const double force_max = can.force_max * map_.scale / least;
  const double late = 0.5 * counted_hold_ + delay_.load(std::memory_order_relaxed) + can.delay;
  const double damping_max = std::min(can.damping_max, kHandMass / late) / least;
  const ForceInput input{record_.tool, record_.velocity,       passed, &found_, force_max,
                         damping_max,  governor_.force_scale()};
  if (used_.model->wants_contacts()) {
    used_.contacts->query(record_.tool, found_, ToolTracker::kMost);
    if (!found_.complete) governor_.stop(Fault::kCrowded);
  }
  const bool begins = !(record_.felt.stiffness > 0.0);  // no contact in the last tick
  record_.felt = used_.model->evaluate(input);
  const double unfelt = unfelt_work(record_.felt.wrench);
  asked_ = true;
  asked_at_ = reading.t;
  held_for_ += -std::expm1(-passed / kHeldFilter) * (passed - held_for_);
  if (held_for_ > counted_hold_ || held_for_ < (1.0 - kSameHold) * counted_hold_) counted_hold_ = held_for_;
  const double margin = keep_passive(record_.felt, begins);

  ForceOutput& felt = record_.felt;
  const double gain = passive_gain_.at(gain_, felt.stored_energy, unfelt);
  felt.wrench.force *= gain;
  felt.wrench.torque *= gain;
  felt.stored_energy = passive_gain_.stored_energy();
  felt.stiffness *= gain_;
  felt.angular_stiffness *= gain_;
  // Clients that render the surface without this loop's delay need no softer one.
  felt.local.stiffness *= wanted_gain_.load(std::memory_order_relaxed);
  record_.margin = felt.stiffness > 0.0 ? margin : 0.0;
  Wrench wanted = map_.to_device(felt.wrench);
  if (can.torque_max == 0.0 && wanted.torque.allFinite()) wanted.torque.setZero();
  // Clamped before it is damped: clamping afterwards would remove the damping. If the model's spring stores
  // S, a force clamped to the fraction rho returns S (2 rho - rho^2) along the way on which S was stored.
  const double rho = share_shown(wanted, can);
  const double stored = std::isnan(felt.stored_energy)
                            ? std::numeric_limits<double>::infinity()
                            : map_.to_device(felt.stored_energy) * (2.0 * rho - rho * rho);
  wanted_ = passivity_.correct({rho * wanted.force, rho * wanted.torque}, stored, record_.sent, reading.pose,
                               passed);
}

PassiveStiffness ServoTick::passive_stiffness(const DeviceCapabilities& device, double held, double delay) {
  const auto bound = [&](double damping) {
    return palpate::passive_stiffness(damping, 0.0, held, delay + device.delay);
  };
  return {bound(device.damping + kHandDamping), device.torque_max > 0.0
                                                    ? bound(device.angular_damping + kHandAngularDamping)
                                                    : std::numeric_limits<double>::infinity()};
}

double ServoTick::longest_arm(const DeviceCapabilities& device, double stiffness, double held) {
  const PassiveStiffness bound = passive_stiffness(device, held);
  return std::sqrt(bound.about / std::min(2.0 * stiffness, bound.along));
}

/// Softens a spring that would be active. A spring K at a lever r is K (n, r x n) (n, r x n)^T, of which
/// neither damping may absorb more than is left of the other: their shares add up. \param felt without a gain
/// \param begins no contact before: the spring is then soft from the start \returns TickRecord::margin
double ServoTick::keep_passive(const ForceOutput& felt, bool begins) {
  const PassiveStiffness bound =
      passive_stiffness(device_.capabilities(), counted_hold_, delay_.load(std::memory_order_relaxed));
  const double along = felt.stiffness / bound.along;
  const double about = map_.to_device(felt.angular_stiffness) / bound.about;
  const double used = felt.at_lever ? along + about : std::max(along, about);
  if (!(used > 0.0)) return 0.0;  // also NaN, which the governor handles
  const double margin = 1.0 / used;
  if (keeps_passive_) {
    gain_max_ = margin;
    if (begins) gain_ = std::min(gain_, gain_max_);
  }
  return margin / std::max(wanted_gain_.load(std::memory_order_relaxed), kLeastGain);
}

double ServoTick::unfelt_work(const Wrench& felt) {
  const Eigen::Vector3d turn = turn_between(turned_, record_.tool.orientation);
  const double work = -0.5 * (torque_ + felt.torque).dot(turn);
  const bool unfelt = asked_ && device_.capabilities().torque_max == 0.0 && std::isfinite(work);
  torque_ = felt.torque;
  turned_ = record_.tool.orientation;
  return unfelt ? work : 0.0;
}

const TickRecord& ServoTick::count_contacts() {
  const bool known = asked_ && used_.model->wants_contacts();
  if (!known) used_.contacts->query(record_.tool, found_, ToolTracker::kMost);
  record_.candidates = found_.candidates;
  record_.filtered = found_.filtered;
  record_.contacts = found_.contacts.size();
  record_.k_max = found_.k_max();
  return record_;
}

void ServoTick::tell() {
  record_.sent_world = {map_.rotation * record_.sent.force, map_.rotation * record_.sent.torque};
  record_.state = governor_.state();
  record_.fault = governor_.fault();
  record_.energy = governor_.energy();
  record_.port_energy = passivity_.port_energy();
  record_.force_scale = governor_.force_scale();
  record_.paused = governor_.is_paused();
  record_.added_damping = passivity_.added_damping();
}

/// \param held by the clutch: the hand moves without the tool
void ServoTick::place_tool(bool held) {
  if (tool_held_ && !held) map_.attach(record_.tool, record_.reading.pose);
  tool_held_ = held;
  record_.map = map_;
  if (!held) record_.tool = map_.to_world(record_.reading.pose);
  record_.velocity = held ? Twist{} : map_.to_world(record_.reading.velocity);
}

/// \returns true if there is a valid new reading.
bool ServoTick::listen(double t) {
  heard_ = device_.read(t, said_) || heard_;
  if (heard_) return governor_.admit(said_, t);
  governor_.admit_none(t);
  return false;
}

const TickRecord& ServoTick::run(double t) {
  change(std::max(0.0, t - record_.t));
  const bool fresh = listen(t);
  const GovernorState before = governor_.state();
  const bool on = before != GovernorState::kFalling && before != GovernorState::kStopped;
  record_.t = t;
  record_.reading = governor_.reading();
  place_tool(clutched_ && before == GovernorState::kStopped);
  if (!on) {  // the tool may be anywhere when the force returns
    used_.model->reset();
    passivity_.reset();
    passive_gain_.reset();
    asked_ = false;
    wanted_ = {};
    const double stiffness = record_.felt.local.stiffness;
    record_.felt = {Wrench{}, record_.tool};
    record_.felt.local.stiffness = stiffness;
    record_.margin = 0.0;
  } else if (fresh) {
    feel();
  }
  record_.sent =
      governor_.release(wanted_, used_.worker != nullptr ? used_.worker->age(t) : 0.0, record_.felt.is_known);
  device_.write(record_.sent);
  tell();
  return record_;
}

}  // namespace palpate

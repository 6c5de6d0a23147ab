#include <palpate/servo/admittance_loop.h>

#include <algorithm>
#include <array>
#include <utility>

namespace palpate {
namespace {

constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
/// Longest time whose travel a late tick makes up for: the motion slows down instead of catching up. The
/// forces of a later tick are those of another place, and a drive that had no setpoint meanwhile has stopped
/// at the last one, so that a setpoint farther ahead would be a jump. Unit: [ticks].
constexpr double kLongestStep = 2.0;

}  // namespace

void AdmittanceLoop::check(const AdmittanceLoopOptions& options) {
  if (options.margin == 0.0) return;
  AdmittanceLoopModel along = options.along, about = options.about;
  along.delay += 0.5 * options.period;
  about.delay += 0.5 * options.period;
  const Admittance& a = options.admittance;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto axis = std::string(kAxes[static_cast<std::size_t>(k)]);
    require_stable({a.mass[k], a.damping[k]}, along, "along " + axis, options.margin);
    require_stable({a.inertia[k], a.angular_damping[k]}, about, "about " + axis, options.margin);
  }
}

DeviceCapabilities AdmittanceLoop::told(const MotionDevice& device, const AdmittanceLoopOptions& options) {
  DeviceCapabilities can = device.capabilities();
  can.kind = Causality::kAdmittance;
  can.damping = options.admittance.damping.minCoeff();
  can.angular_damping = options.admittance.angular_damping.minCoeff();
  can.damping_max = 0.5 * can.damping;
  can.damping_source = DampingSource::kSimulated;  // by the controller, for every device
  const auto late = [](const AdmittanceLoopModel& loop) { return loop.delay + loop.lag + loop.sensor_lag; };
  can.delay = std::max(late(options.along), late(options.about));
  return can;
}

AdmittanceLoop::AdmittanceLoop(std::unique_ptr<MotionDevice> device, const AdmittanceLoopOptions& options)
    : AdmittanceLoop(*device, options) {
  owned_ = std::move(device);
}

AdmittanceLoop::AdmittanceLoop(MotionDevice& device, const AdmittanceLoopOptions& options)
    : device_(device),
      options_(options),
      period_(options.period),
      capabilities_(told(device, options)),
      governor_(
          options.safety.value_or(MotionSafety::of(device.capabilities(), options.limits, options.period))),
      controller_(options.admittance, options.limits) {
  check(options);
}

void AdmittanceLoop::open() {
  device_.open();
  HapticDevice::open();
}

void AdmittanceLoop::enable() {
  device_.enable();
  rests_by_.reset();
  HapticDevice::enable();
}

void AdmittanceLoop::close() noexcept {
  if (!controller_.at_rest()) device_.stop();  // the loop has not ended in its own way
  device_.close();
  HapticDevice::close();
}

void AdmittanceLoop::stop() noexcept {
  governor_.stop(Fault::kStalled);
  device_.stop();
}

bool AdmittanceLoop::come_to_rest() {
  governor_.stop(Fault::kEnded);  // again and again: it may have been resumed
  if (controller_.at_rest()) return true;
  if (!rests_by_) rests_by_ = t_ + controller_.limits().stop_time() + kLongestStep * period_;
  if (t_ < *rests_by_) return false;
  device_.stop();
  return true;
}

void AdmittanceLoop::change(const Admittance& admittance, double contact_stiffness) {
  AdmittanceLoopOptions changed = options_;
  changed.admittance = admittance;
  changed.admittance.damping = admittance.damping.cwiseMax(capabilities_.damping);
  changed.admittance.angular_damping = admittance.angular_damping.cwiseMax(capabilities_.angular_damping);
  changed.along.contact_stiffness = contact_stiffness;
  check(changed);
  options_ = changed;
  next_.back() = changed.admittance;
  next_.publish();
}

bool AdmittanceLoop::read(double t, DeviceReading& reading) {
  t_ = t;
  const bool fresh = device_.read(t, said_);
  heard_ = heard_ || fresh;
  if (!heard_) {
    governor_.admit_none(t);
    return false;
  }
  const bool placed = governor_.knows_place();
  governor_.admit(said_, t);
  if (!placed && governor_.knows_place()) {
    controller_.start(governor_.reading().pose);
    answer_.motion = controller_.motion();
    written_at_ = t;
    started_ = true;
  }
  tell_status();
  if (!started_) return false;
  if (!fresh || status() == DeviceStatus::kFault) return false;
  reading = {said_.t, said_.pose, said_.velocity, said_.hand, said_.buttons, governor_.user()};
  return true;
}

/// Reports the fault that stopped MotionGovernor, or what holds the device.
void AdmittanceLoop::tell_status() noexcept {
  if (governor_.fault() != Fault::kNone) {
    const FaultTraits& fault = traits(governor_.fault());
    set_status(DeviceStatus::kFault, fault.requested ? "" : fault.name.data());  // nothing has failed
  } else if (status() == DeviceStatus::kFault || status() == DeviceStatus::kEnabled) {
    set_status(DeviceStatus::kEnabled, held_by());
  }
}

void AdmittanceLoop::write(const Wrench& wrench) {
  if (!started_) return;
  const double passed = t_ > written_at_ ? t_ - written_at_ : period_;
  const double dt = std::min(passed, kLongestStep * period_);
  written_at_ = t_;
  if (next_.update()) controller_.set(next_.front());
  if (governor_.brakes()) {
    // The velocity falls with the time that has passed. A drive that is told nothing has stopped meanwhile.
    controller_.brake(passed, governor_.doubts_place() ? 0.0 : dt);
  } else {
    const double share = governor_.share();
    const Wrench user = governor_.user();
    controller_.step({share * user.force, share * user.torque}, {share * wrench.force, share * wrench.torque},
                     dt);
  }
  const bool good = governor_.moved(controller_.motion(), answer_.motion, controller_.at_rest());
  if (!good) controller_.start(answer_.motion.pose);
  if (!governor_.knows_place()) return device_.stop();  // a setpoint would pull the handle to another place
  if (governor_.doubts_place()) return;
  answer_ = device_.move(controller_.motion(), dt);
  if (!answer_.held) return;
  held_ = true;
  held_at_ = t_;
  held_reason_ = answer_.reason;
  controller_.follow(answer_.motion);
}

}  // namespace palpate

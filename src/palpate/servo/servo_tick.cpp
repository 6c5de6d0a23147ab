#include <palpate/servo/servo_tick.h>

#include <cmath>

namespace palpate {
namespace {

/// More contacts at once take memory from the heap.
constexpr std::size_t kRoom = 4096;

}  // namespace

ServoTick::ServoTick(HapticDevice& device, ForceModel& model, ToolTracker* contacts, double period)
    : device_(device),
      model_(model),
      contacts_(contacts),
      governor_(SafetyLimits::of(device.capabilities(), period)),
      passivity_(1.0 / device.capabilities().rate, device.capabilities().damping,
                 device.capabilities().damping_max) {
  found_.contacts.reserve(kRoom);
}

void ServoTick::feel(const DeviceReading& reading) {
  if (contacts_ != nullptr) contacts_->query(reading.pose, found_);
  const double dt = asked_ ? reading.t - asked_at_ : 0.0;
  record_.felt =
      model_.evaluate({reading.pose, reading.velocity, dt, contacts_ != nullptr ? &found_ : nullptr});
  record_.contacts = found_.contacts.size();
  asked_ = true;
  asked_at_ = reading.t;
  const bool has_potential = !std::isnan(record_.felt.stored);
  const Wrench passive = passivity_.correct(record_.felt.wrench, has_potential ? record_.felt.stored : 0.0,
                                            record_.sent, reading.pose);
  wanted_ = has_potential ? passive : record_.felt.wrench;
}

const TickRecord& ServoTick::run(double t) {
  device_.read(t, said_);
  const bool fresh = governor_.admit(said_, t);
  const GovernorState before = governor_.state();
  const bool on = before != GovernorState::kFalling && before != GovernorState::kStopped;
  if (!on) {  // the tool may be anywhere when the force comes back
    model_.reset();
    passivity_.reset();
    asked_ = false;
    wanted_ = {};
  } else if (fresh) {
    feel(governor_.reading());
  }
  record_.sent = governor_.release(wanted_, 0.0);
  device_.write(record_.sent);
  record_.t = t;
  record_.reading = governor_.reading();
  record_.state = governor_.state();
  record_.fault = governor_.fault();
  record_.excess = passivity_.excess();
  record_.balance = passivity_.balance();
  record_.added_damping = passivity_.added_damping();
  return record_;
}

}  // namespace palpate

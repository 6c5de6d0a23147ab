#include <support/mujoco_device.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

namespace palpate::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

/// Of the only body besides the world.
constexpr int kHandle = 1;
/// As SimulatedDevice filters the velocity that it tells. Unit: [s].
constexpr double kVelocityFilter = 1.6e-3;
/// Half of the time over which a difference of the hand's path is its velocity. Unit: [s].
constexpr double kInstant = 1e-6;

/// MuJoCo's dry friction is a constraint that gives way a little. These are the hardest it takes: within two
/// steps a handle that it holds is down to a creep of some 1e-8 m/s.
constexpr const char* kHard = R"(solimpfriction="0.9999 0.9999 0.001")";

std::string slide(const char* axis, const PlantProperties& plant, double step) {
  return fmt::format(
      R"(<joint type="slide" axis="{}" damping="{:.17g}" frictionloss="{:.17g}" solreffriction="{:.17g} 1" {}/>)",
      axis, plant.damping, plant.coulomb, 2.0 * step, kHard);
}

std::string ball(const PlantProperties& plant, double step) {
  return fmt::format(
      R"(<joint type="ball" damping="{:.17g}" frictionloss="{:.17g}" solreffriction="{:.17g} 1" {}/>)",
      plant.gyration * plant.gyration * plant.damping, plant.gyration * plant.coulomb, 2.0 * step, kHard);
}

std::string handle_xml(const PlantProperties& plant, const HandProperties& hand, bool turns, double step) {
  const double mass = plant.mass + hand.mass, inertia = plant.gyration * plant.gyration * mass;
  return fmt::format(R"(
<mujoco>
  <option integrator="RK4" solver="Newton" tolerance="0" gravity="0 0 0"><flag contact="disable"/></option>
  <worldbody>
    <body>
      <inertial pos="0 0 0" mass="{0:.17g}" diaginertia="{1:.17g} {1:.17g} {1:.17g}"/>
      {2}{3}{4}{5}
    </body>
  </worldbody>
</mujoco>)",
                     mass, inertia, slide("1 0 0", plant, step), slide("0 1 0", plant, step),
                     slide("0 0 1", plant, step), turns ? ball(plant, step) : std::string());
}

mjModel* compiled(const std::string& xml) {
  constexpr const char* kName = "handle.xml";
  const auto files = std::make_unique<mjVFS>();  // of two megabytes
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), kName, static_cast<int>(xml.size()));
  std::memcpy(files->filedata[0], xml.data(), xml.size());
  std::array<char, 1000> error{};
  mjModel* const model = mj_loadXML(kName, files.get(), error.data(), static_cast<int>(error.size()));
  mj_deleteVFS(files.get());
  if (model == nullptr) throw std::runtime_error(error.data());
  return model;
}

Vector3d turn_between(const Quaterniond& from, const Quaterniond& to) {
  const Eigen::AngleAxisd turn(to * from.conjugate());
  return turn.angle() * turn.axis();
}

Vector3d to_steps(const Vector3d& v, double step) {
  if (step == 0.0) return v;
  return step * (v / step).array().round().matrix();
}

Vector3d no_longer_than(const Vector3d& v, double most) {
  return v.norm() > most ? Vector3d(most * v.normalized()) : v;
}

/// Called by mjcb_control, of which MuJoCo has one for all models; none while a model is compiled.
thread_local const std::function<void()>* at_each_stage = nullptr;

}  // namespace

MujocoDevice::MujocoDevice(const DeviceCapabilities& capabilities, const PlantProperties& plant,
                           const HandProperties& hand, HandPath path, double step)
    : capabilities_(capabilities),
      plant_(plant),
      hand_(hand),
      path_(std::move(path)),
      step_(step),
      turns_(capabilities.torque_max > 0.0),
      model_(compiled(handle_xml(plant, hand, turns_, step))),
      data_(mj_makeData(model_.get())) {
  mju_user_warning = [](const char*) {};  // no log file; advance() looks for itself
  mjcb_control = [](const mjModel*, mjData*) {
    if (at_each_stage != nullptr) (*at_each_stage)();
  };
}

Pose MujocoDevice::pose() const {
  const mjtNum* q = data_->qpos;
  Pose pose;
  pose.position = {q[0], q[1], q[2]};
  pose.orientation = turns_ ? Quaterniond(q[3], q[4], q[5], q[6]) : path_(data_->time).orientation;
  return pose;
}

Twist MujocoDevice::velocity() const {
  const mjtNum* v = data_->qvel;
  Twist velocity;
  velocity.linear = {v[0], v[1], v[2]};
  // A ball joint's is along the axes of the body.
  velocity.angular =
      turns_ ? Vector3d(pose().orientation * Vector3d(v[3], v[4], v[5])) : hand_velocity(data_->time).angular;
  return velocity;
}

Twist MujocoDevice::hand_velocity(double t) const {
  const Pose before = path_(t - kInstant), after = path_(t + kInstant);
  Twist velocity;
  velocity.linear = (after.position - before.position) / (2.0 * kInstant);
  velocity.angular = turn_between(before.orientation, after.orientation) / (2.0 * kInstant);
  return velocity;
}

/// Of the hand and the motors, on the handle as it is at this stage of a step.
void MujocoDevice::apply_wrench() const {
  const Pose is = pose(), wanted = path_(data_->time);
  const Twist moves = velocity(), wanted_moves = hand_velocity(data_->time);
  const Vector3d force = shown_.force + hand_.stiffness * (wanted.position - is.position) +
                         hand_.damping * (wanted_moves.linear - moves.linear);
  const Vector3d torque =
      shown_.torque + plant_.gyration * plant_.gyration *
                          (hand_.stiffness * turn_between(is.orientation, wanted.orientation) +
                           hand_.damping * (wanted_moves.angular - moves.angular));
  mjtNum* const applied = data_->xfrc_applied + 6 * kHandle;
  std::copy_n(force.data(), 3, applied);
  std::copy_n(torque.data(), 3, applied + 3);
}

void MujocoDevice::start(double t) {
  const Pose wanted = path_(t);
  std::copy_n(wanted.position.data(), 3, data_->qpos);
  const Quaterniond& q = wanted.orientation;
  if (turns_) std::copy_n(std::array{q.w(), q.x(), q.y(), q.z()}.data(), 4, data_->qpos + 3);
  data_->time = t;
}

void MujocoDevice::advance(double until) {
  const auto steps = static_cast<int>(std::ceil((until - data_->time) / step_ - 1e-6));
  const std::function<void()> stage = [this] { apply_wrench(); };
  at_each_stage = &stage;
  if (steps > 0) model_->opt.timestep = (until - data_->time) / steps;
  for (int k = 0; k < steps; ++k) mj_step(model_.get(), data_.get());
  at_each_stage = nullptr;
  data_->time = until;  // not to rounding
  for (const mjWarningStat& warning : data_->warning)
    if (warning.number > 0) throw std::runtime_error("MuJoCo has warned of the state");
}

void MujocoDevice::write(const Wrench& wrench) {
  due_.push_back({told_.t + plant_.delay,
                  {no_longer_than(wrench.force, capabilities_.force_max),
                   no_longer_than(wrench.torque, capabilities_.torque_max)}});
}

Pose MujocoDevice::encoded() const {
  Pose seen = pose();
  seen.position = to_steps(seen.position, plant_.resolution);
  const Vector3d turn =
      to_steps(turn_between(Quaterniond::Identity(), seen.orientation), plant_.turn_resolution);
  seen.orientation = Eigen::AngleAxisd(turn.norm(), turn.stableNormalized());
  return seen;
}

void MujocoDevice::tell(double t) {
  const Pose seen = encoded();
  if (started_) {
    const double dt = t - told_.t, share = 1.0 - std::exp(-dt / kVelocityFilter);
    Twist& velocity = told_.velocity;
    velocity.linear += share * ((seen.position - told_.pose.position) / dt - velocity.linear);
    velocity.angular +=
        share * (turn_between(told_.pose.orientation, seen.orientation) / dt - velocity.angular);
  }
  told_.pose = DevicePose(seen);
  told_.t = t;
}

bool MujocoDevice::read(double t, DeviceReading& reading) {
  if (started_ && t <= told_.t) return false;
  if (!started_) start(t);
  for (; !due_.empty() && due_.front().t <= t; due_.pop_front()) {
    advance(due_.front().t);
    shown_ = due_.front().wrench;
  }
  advance(t);
  tell(t);
  started_ = true;
  reading = told_;
  return true;
}

}  // namespace palpate::test

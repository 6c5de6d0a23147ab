#include <palpate/study/reproduction.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <palpate/base/clock.h>
#include <palpate/device/hand_path.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/servo/servo_tick.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kMicro = 1e6;
constexpr double kTremor = 2e-5;    // amplitude of the hand's tremor. [m]
constexpr double kHoldEnd = 0.5;    // end of a hold that counts as rest. [s]
constexpr double kFelt = 0.05;      // least force of a contact. [N]
constexpr double kBack = 5e-5;      // least retreat that makes a lost contact a bounce. [m]
constexpr double kGyration = 0.05;  // of the handle. [m]

/// Wraps a model: finds its contacts by a query of its own, delays its output, and measures its time.
class TimedForce final : public ForceModel {
 public:
  TimedForce(ReproductionModel& model, const Tool& tool)
      : model_(*model.force), contacts_(model.contacts), stall_(model.stall), tool_(tool) {}

  bool wants_contacts() const override { return false; }

  void reset() override {
    model_.reset();
    shown_ = coming_ = {};
    since_ = 0.0;
  }

  ForceOutput evaluate(const ForceInput& input) override {
    if (stall_ == 0.0) return compute(input);
    // The next output is computed while the last one is shown: an output is already late when it is first
    // shown, and ages while it is held.
    since_ += input.dt;
    waited_ += input.dt;
    if (coming_ && since_ < stall_) return held(input);
    ForceInput late = input;
    late.dt = std::exchange(waited_, 0.0);
    since_ = 0.0;
    shown_ = std::exchange(coming_, compute(late));
    return held(input);
  }

  const ContactSet& found() const { return found_; }
  double cpu_us() const { return cpu_us_; }
  double wall_us() const { return wall_us_; }
  void forget_time() { cpu_us_ = wall_us_ = 0.0; }

 private:
  ForceOutput compute(ForceInput input) {
    const double cpu = thread_time(), wall = monotonic_now();
    if (contacts_ != nullptr) {
      query(*contacts_, tool_, input.tool, found_);
      input.contacts = &found_;
    }
    ForceOutput output = model_.evaluate(input);
    cpu_us_ = kMicro * (thread_time() - cpu);
    wall_us_ = kMicro * (monotonic_now() - wall);
    return output;
  }

  ForceOutput held(const ForceInput& input) const {
    ForceOutput output = shown_.value_or(ForceOutput{});
    output.proxy = input.tool;
    output.stored_energy = std::numeric_limits<double>::quiet_NaN();  // unknown for a held force
    return output;
  }

  ForceModel& model_;
  const ContactQuery* contacts_;
  double stall_;
  const Tool& tool_;
  ContactSet found_;
  std::optional<ForceOutput> shown_, coming_;
  double since_ = 0.0, waited_ = 0.0;  ///< Unit: [s].
  double cpu_us_ = 0.0, wall_us_ = 0.0;
};

/// The device under test, with access to the user's force and to its held state.
class Held {
 public:
  Held(ReproductionDevice kind, const GiantSetup& setup, const JointPlantMaker& plant, HandPath hand) {
    if (kind == ReproductionDevice::kAdmittance) {
      auto loop = make_giant_loop(setup, plant(setup, std::move(hand)));
      loop_ = loop.get();
      device_ = std::move(loop);
    } else {
      auto device = std::make_unique<SimulatedDevice>(capabilities(setup), properties(setup), setup.hand,
                                                      std::move(hand));
      simulated_ = device.get();
      device_ = std::move(device);
    }
    device_->open();
    device_->enable();
  }

  HapticDevice& device() { return *device_; }
  Vector3d user() const { return loop_ != nullptr ? loop_->user().force : simulated_->hand_force(); }
  bool held() const { return loop_ != nullptr && *loop_->held_by() != '\0'; }

 private:
  static DeviceCapabilities capabilities(const GiantSetup& setup) {
    DeviceCapabilities can;
    can.name = "impedance";
    can.force_max = 60.0;
    can.stiffness_max = 5000.0;
    can.damping_max = can.damping = admittance_of(setup).damping.minCoeff();
    can.damping_max *= 0.5;
    can.damping_source = DampingSource::kSimulated;
    can.workspace = 2.0;
    can.rate = 1.0 / setup.period;
    return can;
  }
  static PlantProperties properties(const GiantSetup& setup) {
    PlantProperties plant;
    plant.mass = setup.virtual_mass;
    plant.damping = admittance_of(setup).damping.minCoeff();
    plant.gyration = kGyration;
    return plant;
  }

  std::unique_ptr<HapticDevice> device_;
  AdmittanceLoop* loop_ = nullptr;
  SimulatedDevice* simulated_ = nullptr;
};

/// Computes depth and normal of a ball tool in the true surface, in the world frame.
void measure_depth(const ReproductionScene& scene, const Similarity& scene_from_world, double radius,
                   ReproductionTick& tick) {
  tick.depth = std::numeric_limits<double>::quiet_NaN();
  if (scene.surface == nullptr || !(radius > 0.0)) return;
  const NearestPoint nearest = scene.surface->project(scene_from_world * tick.tool);
  tick.depth = radius - scene.world_from_scene.scale * nearest.distance;
  tick.normal = scene.world_from_scene.rotation * nearest.normal;
}

/// Returns the radius of a ball; 0 for any other tool. Unit: [m].
double ball_radius(const Tool& tool) {
  return tool.parts().size() == 1 && tool.longest() == tool.thinnest() ? tool.thinnest() : 0.0;
}

/// Returns the peak to peak of evenly spaced values about their least-squares line.
double swing_of(const std::vector<double>& values) {
  const auto n = static_cast<Eigen::Index>(values.size());
  const Eigen::ArrayXd y = Eigen::Map<const Eigen::ArrayXd>(values.data(), n) - values.front();
  const Eigen::ArrayXd x = Eigen::ArrayXd::LinSpaced(n, -1.0, 1.0);
  const Eigen::ArrayXd about = y - (x * y).sum() / (x * x).sum() * x;
  return about.maxCoeff() - about.minCoeff();
}

ReproductionContact contact_of(const std::vector<ReproductionTick>& ticks, const RoomTouch& touch) {
  ReproductionContact contact;
  contact.begins = std::numeric_limits<double>::quiet_NaN();
  Vector3d force = Vector3d::Zero(), user = Vector3d::Zero(), normal = Vector3d::Zero();
  constexpr double kNoDepth = -std::numeric_limits<double>::infinity();
  double deepest = kNoDepth, mean = 0.0, in_contact = kNoDepth;
  std::vector<double> resting;
  for (const ReproductionTick& tick : ticks) {
    if (tick.t < touch.begins || tick.t > touch.slides) continue;
    const bool now = tick.force.norm() > kFelt;
    if (now && std::isnan(contact.begins)) contact.begins = tick.t;
    contact.colliding = std::max(contact.colliding, tick.colliding);
    const double way = (tick.tool - touch.place.touch.position).dot(touch.place.inward);
    deepest = std::max(deepest, way);
    if (tick.t <= touch.slides - kHoldEnd) {
      // A contact that is lost while the tool moves further in, as behind a thin layer, is no bounce.
      contact.bounces += static_cast<int>(!now && in_contact > way + kBack);
      if (now)
        in_contact = std::max(in_contact, way);
      else
        in_contact = kNoDepth;
      continue;
    }
    resting.push_back(way);
    mean += way;
    force += tick.force;
    user += tick.user;
    normal += tick.normal;
    contact.depth += tick.depth;
  }
  const auto count = static_cast<double>(resting.size());
  contact.force = force.norm() / count;
  contact.user = user.norm() / count;
  contact.depth /= count;
  contact.swing = swing_of(resting);
  contact.overshoot = deepest - mean / count;
  if (force.norm() > 0.0) contact.direction = force.normalized();
  contact.off = std::isnan(contact.depth) || force.isZero(0.0)
                    ? std::numeric_limits<double>::quiet_NaN()
                    : std::acos(std::clamp(contact.direction.dot(normal.normalized()), -1.0, 1.0));
  return contact;
}

/// Adds `name` to `faults`, once.
void note(std::vector<std::string>& faults, std::string_view name) {
  if (std::find(faults.begin(), faults.end(), name) == faults.end()) faults.emplace_back(name);
}

}  // namespace

std::string_view to_string(ReproductionDevice device) {
  return device == ReproductionDevice::kAdmittance ? "admittance" : "impedance";
}

ReproductionRun reproduce(const ReproductionScene& scene, const Tool& tool, const RoomPath& path,
                          ReproductionModel model, ReproductionDevice device, const GiantSetup& setup,
                          const JointPlantMaker& plant, const Progress& progress) {
  ReproductionRun run{model.name, device, model.stall, {}, {}, 0.0, {}, 0};
  const Trajectory& way = path.path;
  Held held(device, setup, plant, with_tremor([&way](double t) { return pose_at(way, t); }, kTremor));
  TimedForce force(model, tool);
  ToolTracker looked(*scene.index, tool);
  FeltModel felt{&force, &looked, nullptr};
  ServoTickOptions options;
  options.period = setup.period;
  options.limits = SafetyLimits::of(held.device().capabilities(), setup.period);
  options.limits->frozen_after = std::numeric_limits<double>::infinity();  // a simulated hand may hold still
  options.limits->force_sustained = options.limits->torque_sustained = 0.0;
  ServoTick tick(held.device(), felt, options);
  const Similarity scene_from_world = scene.world_from_scene.inverse();
  const double radius = ball_radius(tool);
  const auto count = static_cast<std::size_t>(way.back().t / setup.period);
  run.ticks.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    const double t = static_cast<double>(k) * setup.period;
    force.forget_time();
    tick.run(t);
    const TickRecord& record = tick.count_contacts();
    ReproductionTick row;
    row.t = t;
    row.tool = record.tool.position;
    const ContactSet& own = force.found();
    const bool paper = model.contacts != nullptr;
    row.candidates = paper ? own.candidates : record.candidates;
    row.filtered = paper ? own.filtered : record.filtered;
    row.colliding = paper ? own.contacts.size() : record.contacts;
    row.felt = record.felt.wrench.force;
    row.force = record.sent_world.force;
    row.user = held.user();
    row.cpu_us = force.cpu_us();
    row.wall_us = force.wall_us();
    measure_depth(scene, scene_from_world, radius, row);
    run.ticks.push_back(row);
    run.held_ticks += static_cast<std::size_t>(held.held());
    run.port_energy = std::max(run.port_energy, record.port_energy);
    const bool broken = held.device().status() == DeviceStatus::kFault;
    if (broken) note(run.faults, held.device().status_text());
    if (record.fault != Fault::kNone && !broken) note(run.faults, traits(record.fault).name);
    if (k % 1000 == 0)
      report(progress, "simulating, " + run.model + ", " + std::string(to_string(device)),
             static_cast<double>(k) / static_cast<double>(count));
  }
  for (const RoomTouch& touch : path.touches) run.contacts.push_back(contact_of(run.ticks, touch));
  return run;
}

}  // namespace palpate

#include "live_system.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/device/hand_path.h>
#include <palpate/device/profiles.h>
#include <palpate/device/touch_path.h>

#include "output.h"

namespace palpate::cli {
namespace {

constexpr const char* kDeviceGroup = "Device";
constexpr const char* kLoopGroup = "Loop";

/// How fast a hand goes that explores. Unit: [m/s].
constexpr double kExploring = 0.5;
/// Of the hand that explores. Unit: [m].
constexpr double kTremor = 2e-5;
/// Gaussians across a tool from which on a search takes so long that another thread had better do it.
constexpr double kManyContacts = 200.0;

/// As many as lie side by side under a tool that is pressed into a surface.
double contacts_across(const Tool& tool, double extent) {
  double across = 0.0;
  for (const ToolPart& part : tool.parts()) {
    const Eigen::Vector3d& a = part.semi_axes;
    across += a.prod() / (a.minCoeff() * extent * extent);
  }
  return across;
}

/// The same way, no faster than `most`.
Trajectory slowed(Trajectory path, double most) {
  double gained = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double way = (path[i].pose.position - path[i - 1].pose.position).norm();
    const double now = path[i].t + gained;
    path[i].t = std::max(now, path[i - 1].t + way / most);
    gained += path[i].t - now;
  }
  return path;
}

}  // namespace

void DeviceOptions::declare(CLI::App& app) {
  add_choice(app, "--device", device, {"simulated", "playback"},
             "a simulated one in a simulated hand, or poses of --trajectory that no force moves")
      .in_group(kDeviceGroup);
  add_choice(app, "--profile", profile, profile_names(), "whose forces and mechanics it has")
      .in_group(kDeviceGroup);
  add_text(
      app, "--trajectory", trajectory, "T.csv",
      "where the hand wants the tool, in the world; to and fro (default: to touch the scene at seven places)")
      .in_group(kDeviceGroup);
  add_parsed(app, "--hand", "m,b,k", "the simulated hand: kg, N s/m and N/m",
             [this](const std::string& text) { hand = parse_hand(parse_numbers(text, 3, 3).data()); })
      .shows_default(fmt::format("{},{},{}", hand.mass, hand.damping, hand.stiffness))
      .in_group(kDeviceGroup);
  add_number(app, "--workspace-scale", map.scale, 1e-3, 1e6, "1",
             "metres of the world a metre of the hand's way")
      .in_group(kDeviceGroup);
  add_parsed(
      app, "--workspace-rotate", "qw,qx,qy,qz", "rotation from the device to the world",
      [this](const std::string& text) { map.rotation = parse_quaternion(parse_numbers(text, 4, 4).data()); })
      .in_group(kDeviceGroup);
  add_vector3(app, "--workspace-offset", map.offset, "m", "where the device's origin is in the world")
      .in_group(kDeviceGroup);
}

void LoopOptions::declare(CLI::App& app) {
  add_number(app, "--rate", rate, 10.0, 1e4, "Hz", "ticks a second").in_group(kLoopGroup);
  add_choice(
      app, "--contacts", contacts, {"auto", "inline", "worker", "hold"},
      "who looks for contacts: the loop, a thread that looks ahead of it, or one whose force is held (the "
      "paper's)")
      .in_group(kLoopGroup);
  add_number(app, "--worker-delay", worker_delay, 0.0, 1.0, "s",
             "how much longer that thread takes than it must, to see what comes of it")
      .in_group(kLoopGroup);
  add_count(app, "--cpu", cpu, 0, 1023, "processor that the loop stays on").in_group(kLoopGroup);
}

LiveSystem::LiveSystem(const SceneOptions& scene, const QueryOptions& query, const ForceOptions& force,
                       const DeviceOptions& device, const LoopOptions& loop, const Progress& progress)
    : options_(loop), stiffness_(force.proxy.stiffness) {
  read_scene(scene, query, device, progress);
  contacts_ = loop.contacts;
  if (contacts_ == "auto") {
    const bool many = contacts_across(query.tool, index_->usual_extent()) > kManyContacts;
    contacts_ = many && std::thread::hardware_concurrency() > 1 ? "worker" : "inline";
  }
  make_models(scene, query, force, progress);
  make_device(device);
  const auto first = std::find(kModels.begin(), kModels.end(), force.model_for(*index_));
  model_ = static_cast<std::size_t>(first - kModels.begin());
}

void LiveSystem::read_scene(const SceneOptions& scene, const QueryOptions& query, const DeviceOptions& device,
                            const Progress& progress) {
  if (!device.trajectory.empty()) path_ = read_trajectory(device.trajectory);
  if (device.device == "playback" && path_.empty())
    throw Error("--device playback has nothing to play; give --trajectory T.csv");
  scene_text_ = scene.name();
  if (!path_.empty() && !scene.path.empty()) {
    const IndexFiles files = query.no_index_file ? IndexFiles::kNone : IndexFiles::kUse;
    index_ = std::make_unique<SceneIndex>(open_index(scene, files, progress));
    return;
  }
  const LoadedScene loaded = load_or_make(scene, progress);
  index_ = std::make_unique<SceneIndex>(loaded.scene, scene.filter, scene.world_from_scene(), progress);
  if (!path_.empty()) return;
  try {
    path_ = slowed(touch_path(*index_, loaded.kept, query.tool, {}), kExploring * device.map.scale);
  } catch (const Error& error) {
    throw Error("{}: {}; or give --trajectory", scene_text_, error.what());
  }
}

void LiveSystem::make_models(const SceneOptions& scene, const QueryOptions& query, const ForceOptions& force,
                             const Progress& progress) {
  Lookahead* const ahead = contacts_ == "worker" ? &lookahead_ : nullptr;
  const ForceOptions::Materials made_of = force.made_of(scene.path, progress);
  for (std::size_t k = 0; k < kModels.size(); ++k) {
    Model& model = models_[k];
    model.felt = force.build(kModels[k], *index_, query.tool, made_of, ahead);
    model.contacts = std::make_unique<ToolTracker>(*index_, query.tool, Precision::kDouble, ahead);
    if (contacts_ != "hold") continue;
    if (model.felt->wants_contacts()) model.asked = std::make_unique<ToolTracker>(*index_, query.tool);
    model.held = std::make_unique<HeldForce>(*model.felt, model.asked.get());
  }
}

void LiveSystem::make_device(const DeviceOptions& options) {
  DeviceProfile profile = device_profile(options.profile);
  profile.capabilities.rate = options_.rate;  // what is simulated answers whenever it is asked
  const WorkspaceMap map = options.map;
  if (options.device == "playback") {
    for (TimedPose& p : path_) p.pose = map.to_device(p.pose);
    auto playback = std::make_unique<PlaybackDevice>(profile.capabilities, path_);
    length_ = playback->length();
    device_ = std::move(playback);
  } else {
    const HandPath hand = with_tremor(to_and_fro(path_), kTremor);
    device_ = std::make_unique<SimulatedDevice>(profile.capabilities, profile.plant, options.hand,
                                                [=](double t) { return map.to_device(hand(t)); });
  }
  map_ = map;
}

FeltModel LiveSystem::felt(std::size_t k) {
  Model& model = models_[k];
  return {model.held ? model.held.get() : model.felt.get(), model.contacts.get()};
}

void LiveSystem::start(std::vector<TickObserver*> observers) {
  clock_ = LoopClock();
  std::vector<BackgroundWork*> work;
  if (contacts_ == "worker") work.push_back(&lookahead_);
  if (contacts_ == "hold") {
    for (Model& model : models_) work.push_back(model.held.get());
  }
  if (!work.empty()) worker_ = std::make_unique<WorkerThread>(work, clock_, options_.worker_delay);
  ServoTickOptions ticks;
  ticks.period = 1.0 / options_.rate;
  ticks.map = map_;
  ticks.worker = worker_.get();
  tick_ = std::make_unique<ServoTick>(*device_, felt(model_), ticks);
  ServoLoop::Options options;
  options.rate = options_.rate;
  if (options_.cpu >= 0) options.priority.cpu = options_.cpu;
  loop_ = std::make_unique<ServoLoop>(*tick_, clock_, std::move(observers), options);
}

void LiveSystem::stop() {
  loop_->stop();
  worker_.reset();
}

void LiveSystem::use_model(std::size_t k) {
  model_ = k;
  tick_->use(felt(k));
}

}  // namespace palpate::cli

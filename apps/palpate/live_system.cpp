#include "live_system.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <thread>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/collision/ellipsoid_lookup.h>
#include <palpate/device/hand_path.h>
#include <palpate/device/led_hand.h>
#include <palpate/device/profiles.h>
#include <palpate/study/touch_path.h>

#include <palpate/study/procedural.h>

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

bool same(const Similarity& a, const Similarity& b) {
  return a.scale == b.scale && a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation &&
         a.mirrored == b.mirrored;
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

/// Above everything that there is.
Pose waiting_place(const SceneIndex& index, const Tool& tool) {
  Eigen::AlignedBox3d box;
  for (const Ellipsoid& ellipsoid : EllipsoidLookup(index).all().ellipsoids) box.extend(ellipsoid.center);
  Pose pose;
  pose.position = box.center();
  pose.position.z() = box.max().z() + 2.0 * tool.radius();
  return pose;
}

}  // namespace

void DeviceOptions::declare(CLI::App& app) {
  add_choice(app, "--device", device, {"simulated", "playback", "client"},
             "a simulated one in a simulated hand; poses of --trajectory that no force moves; or a client of "
             "the gateway")
      .in_group(kDeviceGroup);
  add_choice(app, "--profile", profile, profile_names(), "whose forces and mechanics it has")
      .in_group(kDeviceGroup);
  add_text(
      app, "--trajectory", trajectory, "T.csv",
      "where the hand wants the tool, in the world; to and fro (default: to touch the scene at seven places)")
      .in_group(kDeviceGroup);
  add_number(app, "--client-rate", client_rate, 1.0, 1e4, "Hz",
             "poses a second that a client sends at least; without three of them there is no force")
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
    : options_(loop),
      contacts_(loop.contacts),
      stiffness_(force.proxy.stiffness),
      map_(device.map),
      settings_{scene, query.tool, force, 0, {}} {
  read_scene(query, device, progress);
  made_of_ = force.made_of(scene.path, progress);
  if (contacts_ == "auto") {
    const bool many = contacts_across(query.tool, index_->usual_extent()) > kManyContacts;
    contacts_ = many && std::thread::hardware_concurrency() > 1 ? "worker" : "inline";
  }
  make_device(device);
  open_device(*device_, [](const std::string& line) { notify("note: " + line); });
  const auto first = std::find(kModels.begin(), kModels.end(), force.model_for(*index_));
  settings_.model = static_cast<std::size_t>(first - kModels.begin());
}

LiveSystem::~LiveSystem() { stop(); }

std::shared_ptr<const SceneIndex> LiveSystem::read_index(const SceneOptions& scene, IndexFiles files,
                                                         const Progress& progress) {
  if (!scene.path.empty()) {
    return std::make_shared<SceneIndex>(open_index(scene, files, progress));
  }
  return std::make_shared<SceneIndex>(load_or_make(scene, progress).scene, scene.filter,
                                      scene.world_from_scene(), progress);
}

void LiveSystem::read_scene(const QueryOptions& query, const DeviceOptions& device,
                            const Progress& progress) {
  const SceneOptions& scene = settings_.scene;
  if (!device.trajectory.empty()) path_ = read_trajectory(device.trajectory);
  if (device.device == "playback" && path_.empty())
    throw Error("--device playback has nothing to play; give --trajectory T.csv");
  index_ = read_index(scene, query.no_index_file ? IndexFiles::kNone : IndexFiles::kCopy, progress);
  exploring_speed_ = kExploring * device.map.scale;
  explores_ = path_.empty() && device.device == "simulated";
  if (!explores_) return;
  try {
    path_ = explore(*index_, query.tool);
  } catch (const Error& error) {
    if (index_->size() == 0) throw Error("{}: {}; or give --trajectory", scene.name(), error.what());
    notify(fmt::format("note: the hand waits above the scene: {}: {}", scene.name(), error.what()));
    path_.emplace_back().pose = waiting_place(*index_, query.tool);
  }
}

Trajectory LiveSystem::explore(const SceneIndex& index, const Tool& tool) const {
  return slowed(touch_path(index, EllipsoidLookup(index).all(), tool, {}), exploring_speed_);
}

void LiveSystem::make_device(const DeviceOptions& options) {
  DeviceProfile profile = device_profile(options.profile);
  if (options.device == "client") {
    profile.capabilities.rate = options.client_rate;
    // Of what a client holds, nobody knows.
    profile.capabilities.damping = profile.capabilities.watchdog = 0.0;
    profile.capabilities.damping_source = DampingSource::kUnknown;
    device_ = std::make_unique<ClientDevice>(profile.capabilities, client_hand_);
    return;
  }
  profile.capabilities.rate = options_.rate;  // what is simulated answers whenever it is asked
  if (options.device == "playback") {
    for (TimedPose& p : path_) p.pose = map_.to_device(p.pose);
    auto playback = std::make_unique<PlaybackDevice>(profile.capabilities, path_);
    length_ = playback->length();
    device_ = std::move(playback);
    return;
  }
  go(path_);
  device_ =
      std::make_unique<SimulatedDevice>(profile.capabilities, profile.plant, options.hand, simulated_hand());
}

/// From here on the simulated hand goes to and fro on `path`.
void LiveSystem::go(const Trajectory& path) {
  way_.back() = std::make_shared<const HandPath>(to_and_fro(path));
  way_.publish();
}

/// On its own way, which may change, or where a client leads it; in the device's frame. The servo thread's.
HandPath LiveSystem::simulated_hand() {
  const HandPath own = [this](double t) {
    way_.update();
    return tick_->map().to_device((*way_.front())(t));
  };
  const LedHand::Lead lead = [this](double) -> std::optional<Pose> {
    const ClientHand::Sample& client = client_hand_.newest();
    if (!client_hand_.is_held()) return std::nullopt;
    return client.pose;
  };
  return with_tremor(LedHand(own, lead), kTremor);
}

std::shared_ptr<FeltScene> LiveSystem::make_felt(std::shared_ptr<const SceneIndex> index,
                                                 const LiveSettings& settings) const {
  ForceOptions force = settings.force;
  force.proxy.stiffness = stiffness_;  // the rest is gain
  force.proxy.hand_scale = map_.scale;
  return std::make_shared<FeltScene>(std::move(index), settings.tool, force, made_of_, contacts_, clock_,
                                     options_.worker_delay);
}

void LiveSystem::start(std::vector<TickObserver*> observers) {
  device_->enable();
  clock_ = LoopClock();
  felt_ = make_felt(index_, settings_);
  ServoTickOptions ticks;
  ticks.period = 1.0 / options_.rate;
  ticks.map = map_;
  if (dynamic_cast<const SimulatedDevice*>(device_.get()) != nullptr) {
    // It cannot freeze, but a client that leads its hand may hold perfectly still.
    ticks.limits = SafetyLimits::of(device_->capabilities(), ticks.period);
    ticks.limits->frozen_after = std::numeric_limits<double>::infinity();
  }
  tick_ = std::make_unique<ServoTick>(*device_, felt_->model(settings_.model), ticks);
  ServoLoop::Options options;
  options.rate = options_.rate;
  if (options_.cpu >= 0) options.priority.cpu = options_.cpu;
  loop_ = std::make_unique<ServoLoop>(*tick_, clock_, std::move(observers), options);
  changer_ = std::thread([this, begin = settings_] { change_until_stopped(begin); });
}

void LiveSystem::stop() {
  {
    const std::scoped_lock lock(mutex_);
    ends_ = true;
  }
  wanted_.notify_all();
  // First of all the force: what is being made ready may take a while to end.
  if (loop_) loop_->stop();
  device_->close();
  if (changer_.joinable()) changer_.join();
}

LiveSettings LiveSystem::settings() const {
  const std::scoped_lock lock(mutex_);
  return settings_;
}

std::string LiveSystem::busy() const {
  const std::scoped_lock lock(mutex_);
  return busy_;
}

std::string LiveSystem::message() const {
  const std::scoped_lock lock(mutex_);
  return message_;
}

std::uint64_t LiveSystem::version() const {
  const std::scoped_lock lock(mutex_);
  return version_;
}

std::shared_ptr<const FeltScene> LiveSystem::felt() const {
  const std::scoped_lock lock(mutex_);
  return felt_;
}

void LiveSystem::change(const std::function<void(LiveSettings&)>& edit) {
  {
    const std::scoped_lock lock(mutex_);
    LiveSettings next = settings_;
    edit(next);
    settings_ = std::move(next);
    ++settings_version_;
    ++version_;
  }
  wanted_.notify_all();
}

void LiveSystem::say(const std::string& busy) {
  const std::scoped_lock lock(mutex_);
  busy_ = busy;
  ++version_;
}

/// \param done what is felt already
void LiveSystem::change_until_stopped(LiveSettings done) {
  std::uint64_t seen = 0;
  for (;;) {
    std::unique_lock lock(mutex_);
    wanted_.wait(lock, [&] { return ends_ || settings_version_ != seen; });
    if (ends_) return;
    const LiveSettings wanted = settings_;
    seen = settings_version_;
    lock.unlock();
    std::string failure;
    try {
      apply(wanted, done);
      done = wanted;
    } catch (const Error& error) {
      failure = error.what();
    } catch (const std::bad_alloc&) {
      failure = "not enough memory for that; it stays as it was";
    }
    if (!failure.empty()) next_.reset();
    lock.lock();
    // What has been asked for meanwhile is not lost: it is tried next.
    if (!failure.empty() && settings_version_ == seen) settings_ = done;
    if (!failure.empty()) set_gain(done);
    message_ = failure;
    busy_.clear();
    ++version_;
  }
}

void LiveSystem::set_gain(const LiveSettings& settings) {
  if (stiffness_ > 0.0) tick_->set_gain(settings.force.proxy.stiffness / stiffness_);
}

/// Makes what is new in `wanted`, has the loop feel it, and waits until it does.
void LiveSystem::apply(const LiveSettings& wanted, const LiveSettings& now) {
  set_gain(wanted);
  const SceneFilter &filter = wanted.scene.filter, &filter_before = now.scene.filter;
  const bool other_place = !same(wanted.scene.world_from_scene(), now.scene.world_from_scene());
  const bool other_gaussians = filter.opacity_min != filter_before.opacity_min ||
                               filter.sigma != filter_before.sigma || filter.iso != filter_before.iso ||
                               (other_place && (filter.max_scale || filter.crop_box || filter.crop_sphere));
  const bool other_tool = tool_json(wanted.tool) != tool_json(now.tool);
  const ProxyParameters &proxy = wanted.force.proxy, &before = now.force.proxy;
  const bool other_feel = proxy.friction != before.friction || proxy.detail != before.detail;
  std::shared_ptr<const SceneIndex> index = index_;
  if (other_gaussians) {
    say("looking which Gaussians can be felt");
    index = read_index(wanted.scene, IndexFiles::kNone, {});
  } else if (other_place) {
    index = std::make_shared<SceneIndex>(index_->registered(wanted.scene.world_from_scene()));
  }
  const bool other_scene = other_gaussians || other_place;
  if (other_scene || other_tool || other_feel) {
    if (!other_gaussians) say("making it ready");
    next_ = make_felt(index, wanted);
  } else if (wanted.model != now.model) {
    next_ = felt_;
  } else {
    return;
  }
  if (explores_ && (other_scene || other_tool)) {
    try {
      go(explore(*index, wanted.tool));
    } catch (const Error&) {
      // There is no place to touch by itself: it goes on where it went, and a client may lead it elsewhere.
    }
  }
  tick_->use(next_->model(wanted.model));
  constexpr double kLook = 5e-3;  // s
  while (!tick_->is_used()) {
    sleep_until(monotonic_now() + kLook);
    const std::scoped_lock lock(mutex_);
    if (ends_) return;  // both stay until the loop has stopped
  }
  {
    const std::scoped_lock lock(mutex_);
    felt_.swap(next_);
    index_ = index;
  }
  next_.reset();  // what was felt before, with its worker
}

}  // namespace palpate::cli

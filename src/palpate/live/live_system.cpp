#include <palpate/live/live_system.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <limits>
#include <new>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/collision/ellipsoid_lookup.h>
#include <palpate/device/hand_path.h>
#include <palpate/device/led_hand.h>
#include <palpate/device/plugin_device.h>
#include <palpate/device/simulated_device.h>
#include <palpate/live/config_fields.h>
#include <palpate/live/factories.h>
#include <palpate/live/simulated_hand.h>
#include <palpate/study/room_path.h>
#include <palpate/study/touch_path.h>

namespace palpate {
namespace {

/// Time for which a simulated hand stays at the rest position of the handle while the force sensor measures
/// its bias. Unit: [s].
constexpr double kTares = 1.5;
/// Time for a simulated hand to reach another scene. Unit: [s].
constexpr double kMoves = 1.5;
/// Longest time without a tick after which a loop that is to end is taken to hang in its driver. Unit: [s].
constexpr double kEnds = 1.0;
/// Longest time for a driver to close its device, after which it is taken to hang: a device may have to be
/// parked or a network connection to be ended. Unit: [s].
constexpr double kCloses = 5.0;
constexpr const char* kFollows = "the first hand owns the scene; change it there";
/// Number of Gaussians across a tool above which a search is slow enough for a thread of its own.
constexpr double kManyContacts = 200.0;
/// Number of Gaussians across a tool above which its size or the scale of the scene is taken to be a mistake.
constexpr double kMistaken = 1e5;

/// Estimates how many Gaussians lie side by side under a tool that is pressed into a surface.
double contacts_across(const Tool& tool, double extent) {
  double across = 0.0;
  for (const ToolPart& part : tool.parts()) {
    const Eigen::Vector3d& a = part.semi_axes;
    across += a.prod() / (a.minCoeff() * extent * extent);
  }
  return across;
}

/// Returns a pose above all Gaussians.
Pose waiting_place(const SceneIndex& index, const Tool& tool) {
  Eigen::AlignedBox3d box;
  for (const Ellipsoid& ellipsoid : EllipsoidLookup(index).all().ellipsoids) box.extend(ellipsoid.center);
  Pose pose;
  pose.position = box.center();
  pose.position.z() = box.max().z() + 2.0 * tool.radius();
  return pose;
}

/// Returns the scene with the materials of `force`: those it has, or those of another file.
SharedScene with_materials(SharedScene scene, const ForceConfig& force) {
  if (force.materials == scene.materials_file) return scene;
  scene.materials = load_materials(force, scene.config.path);
  scene.materials_file = force.materials;
  return scene;
}

/// Runs `work`. \returns what it throws, as a message; empty: nothing
template <class Work>
std::string failure_of(const Work& work) {
  std::string failure;
  try {
    work();
    return failure;
  } catch (const std::bad_alloc&) {
    failure = "not enough memory; the settings are unchanged";
  } catch (const std::exception& error) {  // also of the callbacks of an application
    failure = message_line(error.what());
  } catch (...) {
  }
  return failure.empty() ? "it failed for an unknown reason" : failure;
}

LedHand::Lead waits_at(const Pose& home) {
  return [home](double t) { return t < kTares ? std::optional(home) : std::nullopt; };
}

}  // namespace

LiveSystem::LiveSystem(const LiveConfig& config, std::unique_ptr<HapticDevice> device, const Notify& notify,
                       const Progress& progress)
    : LiveSystem(config, nullptr, std::move(device), notify, progress) {}

LiveSystem::LiveSystem(const LiveConfig& config, const SharedScene& scene,
                       std::unique_ptr<HapticDevice> device, const Notify& notify)
    : LiveSystem(config, &scene, std::move(device), notify, {}) {}

/// \param scene loaded by another system; null: it is loaded here
LiveSystem::LiveSystem(const LiveConfig& config, const SharedScene* scene,
                       std::unique_ptr<HapticDevice> device, const Notify& notify, const Progress& progress)
    : notify_([notify](const std::string& line) {
        if (notify) notify(line);
      }),
      contacts_(config.loop.contacts),
      stiffness_(config.force.proxy.stiffness > 0.0 ? config.force.proxy.stiffness
                                                    : ProxyParameters().stiffness),
      owns_device_(device == nullptr && config.device.driver.empty()),
      follows_(scene != nullptr),
      settings_(config) {
  check_config(config);
  const DeviceKind kind = config.device.kind;
  device_kind_ = owns_device_ ? to_string(kind) : "external";
  if (owns_device_) read_motion();
  scene != nullptr ? take(*scene) : read_scene(progress);
  const double extent = scene_.index->usual_extent();
  const double across = extent > 0.0 ? contacts_across(config.tool, extent) : 0.0;
  if (across > kMistaken) {
    notify_(
        fmt::format("warning: the tool is {:.3g} m large and the Gaussians of the scene {:.2g} m: lengths "
                    "are in metres; give a smaller --tool or a larger --scale",
                    config.tool.radius(), extent));
  }
  if (owns_device_ && is_giant(kind)) place_giant();
  explores_ = owns_device_ && path_.empty() && (kind == DeviceKind::kSimulated || is_giant(kind));
  if (explores_) find_way();
  if (contacts_ == ContactSearch::kAuto) {
    contacts_ = across > kManyContacts && std::thread::hardware_concurrency() > 1 ? ContactSearch::kWorker
                                                                                  : ContactSearch::kInline;
  }
  const std::string& driver = config.device.driver;
  if (device == nullptr && !driver.empty()) device = make_plugin_device(driver);
  open(std::move(device));
}

LiveSystem::~LiveSystem() {
  stop();
  if (device_hangs_) static_cast<void>(device_.release());
}

void LiveSystem::read_motion() {
  const DeviceConfig& device = settings_.device;
  if (!device.trajectory.empty()) path_ = read_trajectory(device.trajectory);
  if (device.kind == DeviceKind::kPlayback && path_.empty())
    throw Error("--device playback needs --trajectory T.csv");
}

void LiveSystem::read_scene(const Progress& progress) {
  const SceneConfig& scene = settings_.scene;
  const ForceConfig& force = settings_.force;
  const IndexFiles files = scene.no_index_file ? IndexFiles::kNone : IndexFiles::kCopy;
  scene_.config = scene;
  scene_.index = std::make_shared<SceneIndex>(open_or_make_index(scene, files, notify_, progress));
  scene_.origin = scene_origin(scene);
  scene_.materials = load_materials(force, scene.path, progress);
  scene_.materials_file = force.materials;
}

/// Uses a scene that another system has loaded.
void LiveSystem::take(const SharedScene& scene) {
  settings_.scene = scene.config;
  scene_ = followed_ = with_materials(scene, settings_.force);
}

/// Determines where the giant's handle rests, and by default places the scene below that, within reach.
void LiveSystem::place_giant() {
  giant_ = giant_setup(settings_.device, settings_.loop.rate, stiffness_);
  home_ = rest_of_handle(giant_->chain);
  WorkspaceMap& map = settings_.device.map;
  if (map != WorkspaceMap() || scene_.index->size() == 0) return;
  map.offset = waiting_place(*scene_.index, settings_.tool).position - home_->position;
  notify_(
      fmt::format("note: the scene is placed below the rest position of the handle: --workspace-offset "
                  "{:.3f},{:.3f},{:.3f}",
                  map.offset.x(), map.offset.y(), map.offset.z()));
}

/// Plans the path of an exploring hand.
void LiveSystem::find_way() {
  const std::string name = settings_.scene.name();
  try {
    path_ = explore(*scene_.index, settings_);
  } catch (const Error& error) {
    if (scene_.index->size() == 0) throw Error("{}: {}; or give --trajectory", name, error.what());
    notify_(fmt::format("note: the hand waits above the scene: {}: {}", name, error.what()));
    path_.emplace_back().pose = waiting_place(*scene_.index, settings_.tool);
  }
}

Trajectory LiveSystem::explore(const SceneIndex& index, const LiveConfig& config) const {
  if (home_) return explore_room(index, config);
  TouchPathOptions options;  // limits of the hand, whose path is longer in the world by the scale
  options.speed *= config.device.map.scale;
  options.acceleration *= config.device.map.scale;
  return touch_path(index, EllipsoidLookup(index).all(), config.tool, options);
}

/// Plans a path within the reach of a giant.
Trajectory LiveSystem::explore_room(const SceneIndex& index, const LiveConfig& config) const {
  if (!config.device.chain.empty())
    throw Error("the reach of {} is unknown; give --trajectory", config.device.chain);
  const WorkspaceMap& map = config.device.map;
  const Eigen::AlignedBox3d reach = giant_reach();
  RoomPathOptions options;
  options.home = map.to_world(DevicePose(*home_));
  options.wait = kTares;
  for (int corner = 0; corner < 8; ++corner)
    options.reach.extend(
        map.to_world(DevicePose{reach.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)), {}})
            .position);
  return room_path(index, EllipsoidLookup(index).all(), config.tool, options).path;
}

/// Opens `device`; null: creates the one of the configuration.
void LiveSystem::open(std::unique_ptr<HapticDevice> device) {
  const DeviceConfig& config = settings_.device;
  if (device == nullptr) {
    DeviceConnections connections;
    connections.client_hand = &client_hand_;
    if (config.kind == DeviceKind::kPlayback) {
      for (TimedPose& p : path_) p.pose = config.map.to_device(p.pose).in_device_frame();
      length_ = path_.back().t - path_.front().t;
      connections.playback = path_;
    } else if (config.kind == DeviceKind::kSimulated || home_) {
      go(path_);
      const HandPath own = [this](double t) {
        way_.update();
        return tick_->map().to_device((*way_.front())(t)).in_device_frame();
      };
      connections.hand = simulated_hand(own, client_hand_, moves_itself_);
      if (home_) connections.hand = LedHand(connections.hand, waits_at(*home_));
    }
    connections.giant = giant_;
    device = make_device(config, settings_.loop.rate, std::move(connections));
  }
  device_ = std::move(device);
  guarded_.emplace(*device_);
  admittance_ = dynamic_cast<AdmittanceLoop*>(device_.get());
  open_device(*device_, [this](const std::string& line) { notify_("note: " + line); });
}

/// Makes the simulated hand move back and forth along `path` from now on.
void LiveSystem::go(const Trajectory& path) {
  way_.back() = std::make_shared<const HandPath>(to_and_fro(path));
  way_.publish();
}

std::shared_ptr<FeltScene> LiveSystem::make_felt(std::shared_ptr<const SceneIndex> index,
                                                 const LiveConfig& settings,
                                                 const Materials& materials) const {
  ForceConfig force = settings.force;
  force.proxy.stiffness = stiffness_;  // at gain 1; set_stiffness() sets the gain
  const DeviceCapabilities& can = device_->capabilities();
  const double held = 1.0 / std::min(settings.loop.rate, can.rate);
  const double wanted = settings.force.proxy.stiffness > 0.0 ? settings.force.proxy.stiffness : stiffness_;
  force.proxy.hand_scale = settings.device.map.scale;
  force.proxy.arm_max = force.proxy.hand_scale * ServoTick::longest_arm(can, wanted, held);
  MakeAround around;
  if (touch_ != nullptr)
    around = [&](ForceModel& model) { return touch_->around(number_, model, settings.tool, stiffness_); };
  return std::make_shared<FeltScene>(std::move(index), settings.tool, force, materials, contacts_, clock_,
                                     settings.loop.worker_delay, settings.scene.path, around);
}

void LiveSystem::enable() {
  if (ends_) throw Error("the system was stopped, which closed its device; construct another LiveSystem");
  if (enabled_) return;
  enable_device(*device_);
  enabled_ = true;
}

void LiveSystem::start(std::vector<TickObserver*> observers) {
  enable();
  if (tick_ != nullptr) throw Error("the system runs already; call LiveSystem::start() once");
  clock_ = LoopClock();
  felt_ = make_felt(scene_.index, settings_, scene_.materials);
  ServoTickOptions ticks;
  ticks.period = 1.0 / settings_.loop.rate;
  ticks.map = settings_.device.map;
  ticks.gain = settings_.force.proxy.stiffness / stiffness_;
  if (dynamic_cast<const SimulatedDevice*>(device_.get()) != nullptr || home_) {
    // A simulated reading never freezes, but a client that leads the hand may hold it perfectly still.
    ticks.limits = SafetyLimits::of(device_->capabilities(), ticks.period);
    ticks.limits->frozen_after = std::numeric_limits<double>::infinity();
  }
  tick_ = std::make_unique<ServoTick>(*guarded_, felt_->model(settings_.force.model), ticks);
  running_.store(tick_.get());
  if (const Fault why = asked_to_stop_.load(); why != Fault::kNone) stop_force(why);
  ServoLoop::Options options;
  options.rate = settings_.loop.rate;
  if (settings_.loop.cpu >= 0) options.priority.cpu = settings_.loop.cpu;
  active_ = fallback_ = settings_;
  loop_ = std::make_unique<ServoLoop>(*tick_, clock_, std::move(observers), options);
  try {
    changer_ = std::thread([this, begin = settings_] { change_until_stopped(begin); });
  } catch (...) {
    stop();  // before the observers are gone
    throw;
  }
}

void LiveSystem::stop() {
  {
    const std::scoped_lock lock(mutex_);
    if (std::exchange(ends_, true)) return;
  }
  wanted_.notify_all();
  // The force is stopped first: the changer thread may need a while to finish.
  if (loop_ && !loop_->stop(kEnds)) {
    if (guarded_->abandon()) {
      loop_->abandon();
      device_hangs_ = true;
    } else {
      loop_->stop();
    }
  }
  device_hangs_ = device_hangs_ || !close_device(*device_, kCloses);
  if (device_hangs_) device_->stop();
  if (changer_.joinable()) changer_.join();
}

void LiveSystem::stop_force(Fault why) {
  if (why == Fault::kEnded || why == Fault::kRecorder) is_over_.store(true);
  asked_to_stop_.store(why);  // before it is looked at whether it runs: start() does it the other way round
  ServoTick* const tick = running_.load();
  if (tick == nullptr) return;
  tick->governor().stop(why);
  // The handle can still be moved in a pause, and where the force returns by itself.
  if (admittance_ != nullptr && traits(why).latched && why != Fault::kPaused)
    admittance_->governor().stop(why);
}

void LiveSystem::stop_motors() noexcept {
  if (ServoTick* const tick = running_.load(std::memory_order_acquire)) return tick->stall();
  device_->stop();
}

void LiveSystem::resume() {
  if (tick_ == nullptr || is_over_.load()) return;
  if (admittance_ != nullptr) admittance_->governor().resume();
  tick_->governor().resume();
  if (is_over_.load()) stop_force(Fault::kEnded);  // it ended meanwhile
}

LiveConfig LiveSystem::settings() const {
  const std::scoped_lock lock(mutex_);
  return settings_;
}

Provenance LiveSystem::provenance(std::string_view command) const {
  using enum ConfigGroup;
  LiveConfig config;
  SceneOrigin scene;
  {
    const std::scoped_lock lock(mutex_);
    config = felt_ ? active_ : settings_;  // those of settings_ may be in progress yet
    config.force.proxy.stiffness = settings_.force.proxy.stiffness;
    scene = scene_.origin;
  }
  Provenance known = palpate::provenance(command, scene, config, {kScene, kTool, kForce, kDevice, kLoop});
  known.made.push_back({"device", toml_quoted(fmt::format("{} ({})", device().name, device_kind()))});
  return known;
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

SharedScene LiveSystem::scene() const {
  const std::scoped_lock lock(mutex_);
  return scene_;
}

std::shared_ptr<const FeltScene> LiveSystem::felt() const {
  const std::scoped_lock lock(mutex_);
  return felt_;
}

void LiveSystem::change(const std::function<void(LiveConfig&)>& edit) { become(edit, nullptr); }

std::string_view LiveSystem::needs_its_scene() const {
  if (home_) return "the scene of a room-scale device is placed at start-up";
  if (device_kind_ == to_string(DeviceKind::kPlayback)) return "a playback belongs to its scene";
  return {};
}

bool LiveSystem::uses_world() const {
  const std::scoped_lock lock(mutex_);
  const SceneFilter& filter = settings_.scene.filter;
  return home_ || client_hand_.is_held() || !settings_.device.trajectory.empty() ||
         settings_.device.map != WorkspaceMap() || !settings_.force.materials.empty() || filter.max_scale ||
         filter.crop_box || filter.crop_sphere;
}

void LiveSystem::open_scene(const std::string& path) {
  if (follows_) throw Error("{}", kFollows);
  if (const auto why = needs_its_scene(); !why.empty()) throw Error("{}; restart with the other scene", why);
  become(
      [](LiveConfig& settings) {
        SceneConfig& scene = settings.scene;
        scene.registration = {};
        scene.frame = UpAxis::kAsIs;
        scene.filter.max_scale.reset();
        scene.filter.crop_box.reset();
        scene.filter.crop_sphere.reset();
        settings.room = {};
      },
      &path);
}

/// Returns `settings` with an edit, which cannot change all of them. \param path another scene; null: the
/// same
LiveConfig LiveSystem::edited(const LiveConfig& settings, const std::function<void(LiveConfig&)>& edit,
                              const std::string* path) const {
  LiveConfig next = settings;
  edit(next);
  if (follows_ && next.scene != settings.scene) throw Error("{}", kFollows);
  next.scene.path = settings.scene.path;
  next.scene.no_index_file = settings.scene.no_index_file;
  next.force.materials = settings.force.materials;
  if (path != nullptr) {
    next.scene.path = *path;
    next.scene.scale_known = next.scene.frame_known = path->empty();
    next.force.materials.clear();
  }
  next.device = settings.device;
  next.loop = settings.loop;
  next.gateway = settings.gateway;
  check_config(next);
  return next;
}

/// \param path another scene; null: the same
void LiveSystem::become(const std::function<void(LiveConfig&)>& edit, const std::string* path) {
  if (tick_ == nullptr)
    throw Error("the system has not started; change the LiveConfig that it is constructed from");
  {
    const std::scoped_lock lock(mutex_);
    const std::uint64_t before = settings_version_;
    LiveConfig next = edited(settings_, edit, path), back = edited(fallback_, edit, path);
    if (settings_version_ != before)
      throw Error("an edit of LiveSystem::change() changes the system itself; change its argument only");
    settings_ = std::move(next);
    fallback_ = std::move(back);
    set_gain();
    message_.clear();
    ++settings_version_;
    ++version_;
  }
  wanted_.notify_all();
}

void LiveSystem::follow(const SharedScene& scene) {
  {
    const std::scoped_lock lock(mutex_);
    if (scene.config.path != settings_.scene.path) {
      settings_.force.materials.clear();
      settings_.room = {};
    }
    settings_.scene = scene.config;
    fallback_.scene = settings_.scene;
    fallback_.force.materials = settings_.force.materials;
    fallback_.room = settings_.room;
    followed_ = scene;
    message_.clear();
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

/// Returns a callback that reports the loading of a scene, in steps that a person can follow.
Progress LiveSystem::progress_of(const std::string& name) {
  return [this, name, told = -1](std::string_view stage, double fraction) mutable {
    constexpr int kSteps = 50;
    const int step = static_cast<int>(kSteps * fraction);
    if (step == std::exchange(told, step)) return;
    say(fmt::format("{}: {} {:.0f} %", name, stage, 100.0 * fraction));
  };
}

/// \param done settings that are in effect
void LiveSystem::change_until_stopped(LiveConfig done) {
  std::uint64_t seen = 0;
  for (;;) {
    std::unique_lock lock(mutex_);
    wanted_.wait(lock, [&] { return ends_ || settings_version_ != seen; });
    if (ends_) return;
    const LiveConfig wanted = settings_;
    const SharedScene followed = followed_;
    seen = settings_version_;
    fallback_ = done;
    lock.unlock();
    const std::string failure = failure_of([&] {
      change_admittance(wanted.force.proxy.stiffness);
      apply(wanted, done, follows_ ? taken_over(wanted, followed) : read_again(wanted, done));
      done = wanted;
    });
    if (!failure.empty()) next_.reset();
    lock.lock();
    if (failure.empty()) {
      active_ = done;
    } else {
      revert(done);
      message_ = failure;  // become() clears it
    }
    busy_.clear();
    ++version_;
  }
}

/// Reverts the settings after a failed change. Those requested meanwhile are kept, and applied next. The
/// stiffness is in effect already, and kept in `done` too, unless the admittance is not stable with it.
/// \param done settings that are in effect. \pre mutex_ is locked
void LiveSystem::revert(LiveConfig& done) {
  double& in_effect = done.force.proxy.stiffness;
  const double stiffness = settings_.force.proxy.stiffness;
  settings_ = fallback_;
  try {
    change_admittance(stiffness);
    in_effect = stiffness;
  } catch (const Error&) {
    change_admittance(in_effect);
  }
  settings_.force.proxy.stiffness = in_effect;
  set_gain();
}

/// Applies the stiffness of settings_, at once, whatever is being built. \pre mutex_ is locked
void LiveSystem::set_gain() { tick_->set_gain(settings_.force.proxy.stiffness / stiffness_); }

/// Adapts the admittance of a giant to the stiffness. \throws Error if it is not stable with that.
void LiveSystem::change_admittance(double stiffness) {
  if (!giant_) return;
  GiantSetup setup = *giant_;
  setup.contact_stiffness = stiffness;
  admittance_->change(admittance_of(setup), stiffness);
}

/// Makes the simulated hand explore another scene, or the scene with another tool. A scene of another size
/// may be so far away that the way would take minutes: then the tool is moved there by the workspace map.
void LiveSystem::lead_hand(const SceneIndex& index, const LiveConfig& wanted) {
  Trajectory path;
  try {
    path = explore(index, wanted);
  } catch (const Error&) {
    // No place to touch was found; a client may lead the hand to one.
    if (index.size() > 0 && !home_) path.emplace_back().pose = waiting_place(index, wanted.tool);
  }
  if (!path.empty()) {
    go(path);
    if (!home_ && !client_hand_.is_held()) tick_->bring(path.front().pose, kMoves * LedHand::kSpeed);
  }
  let_hand_move();
}

/// Withholds the force while the hand moves to the beginning of its new path: otherwise the tool would be
/// pushed through the walls of objects that now surround it.
void LiveSystem::let_hand_move() {
  constexpr double kAgain = 5e-3;  // s
  const double until = monotonic_now() + kMoves;
  while (moves_itself() && monotonic_now() < until) {
    tick_->governor().stop(Fault::kChanging);
    sleep_until(monotonic_now() + kAgain);
    const std::scoped_lock lock(mutex_);
    if (ends_) return;
  }
}

/// Returns the scene of `wanted`. Only what differs from `now` is built anew.
SharedScene LiveSystem::read_again(const LiveConfig& wanted, const LiveConfig& now) {
  const SceneFilter& filter = wanted.scene.filter;
  const bool other_file = wanted.scene.path != now.scene.path;
  const bool other_place = wanted.scene.world_from_scene() != now.scene.world_from_scene();
  const bool other_gaussians = other_file || filter != now.scene.filter ||
                               (other_place && (filter.max_scale || filter.crop_box || filter.crop_sphere));
  SharedScene next = scene_;
  next.config = wanted.scene;
  if (other_file) {
    const std::string name = std::filesystem::path(wanted.scene.name()).filename().string();
    const Progress progress = progress_of("opening " + name);
    const IndexFiles files = wanted.scene.no_index_file ? IndexFiles::kNone : IndexFiles::kCopy;
    say("opening " + name);
    next.index = std::make_shared<SceneIndex>(open_or_make_index(wanted.scene, files, notify_, progress));
    if (next.index->size() == 0)
      throw Error("{}: no Gaussian passes the filter; the current scene stays", name);
    next.materials = load_materials(wanted.force, wanted.scene.path, progress);
    next.materials_file = wanted.force.materials;
    next.origin = scene_origin(wanted.scene);
  } else if (other_gaussians) {
    say("filtering the scene");
    next.index = std::make_shared<SceneIndex>(open_or_make_index(wanted.scene, IndexFiles::kNone, notify_));
    // Another file may have that name by now. It is opened by open_scene() only, not with settings of the old
    // one.
    if (scene_origin(wanted.scene).checksum != scene_.origin.checksum)
      throw Error(
          "{}: the file has changed since it was opened, and the filter needs the old one; restart to "
          "load the new one",
          wanted.scene.name());
  } else if (other_place) {
    next.index = std::make_shared<SceneIndex>(scene_.index->registered(wanted.scene.world_from_scene()));
  }
  return next;
}

/// Returns the scene of the followed system if it is a new one, and the one of `wanted`; otherwise the active
/// scene.
SharedScene LiveSystem::taken_over(const LiveConfig& wanted, const SharedScene& followed) const {
  const bool other = followed.index != scene_.index && followed.config == wanted.scene;
  return other ? with_materials(followed, wanted.force) : scene_;
}

/// Builds what `wanted` changes, on `scene`, passes it to the loop, and waits until the loop uses it.
void LiveSystem::apply(const LiveConfig& wanted, const LiveConfig& now, const SharedScene& scene) {
  const bool other_scene = scene.index != scene_.index;
  const bool other_tool = wanted.tool != now.tool;
  const ProxyParameters &proxy = wanted.force.proxy, &before = now.force.proxy;
  const bool other_feel = proxy.friction != before.friction || proxy.detail != before.detail ||
                          wanted.force.density != now.force.density;
  if (other_scene || other_tool || other_feel) {
    if (busy().empty()) say("preparing the force model");
    next_ = make_felt(scene.index, wanted, scene.materials);
  } else if (wanted.force.model != now.force.model) {
    next_ = felt_;
  } else {
    return;
  }
  if (explores_ && (other_scene || other_tool)) lead_hand(*scene.index, wanted);
  tick_->use(next_->model(wanted.force.model));
  constexpr double kLook = 5e-3;  // s
  while (!tick_->is_used()) {
    sleep_until(monotonic_now() + kLook);
    const std::scoped_lock lock(mutex_);
    if (ends_) return;  // both scenes are kept until the loop has stopped
  }
  {
    const std::scoped_lock lock(mutex_);
    felt_.swap(next_);
    scene_ = scene;
    active_ = wanted;
  }
  next_.reset();  // the previous scene, with its worker
  if (other_scene && on_scene) announce(scene);
}

/// Calls on_scene, for a scene that is in use.
void LiveSystem::announce(const SharedScene& scene) {
  const std::string failure = failure_of([&] { on_scene(scene); });
  if (failure.empty()) return;
  const std::scoped_lock lock(mutex_);
  message_ = fmt::format("the scene is in use, but the application could not take it: {}", failure);
  ++version_;
}

}  // namespace palpate

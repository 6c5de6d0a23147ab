// The live system as an application embeds it: with a device of its own.
#include <palpate/live/live_system.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/device/testing/scripted_device.h>
#include <palpate/kinematics/chain_file.h>
#include <palpate/scene/ply_writer.h>
#include <palpate/servo/live_view.h>
#include <palpate/study/procedural.h>

#include <support/live_scene.h>
#include <support/temporary_file.h>

namespace palpate::test {
namespace {

/// Comes down until the tool, 40 mm long, is 2 mm in the plane.
std::unique_ptr<HapticDevice> own_device() {
  DeviceCapabilities can;
  can.name = "own";
  can.force_max = 10.0;
  return std::make_unique<ScriptedDevice>(can, [](double t) {
    Pose pose;
    pose.position.z() = std::max(0.038, 0.06 - 0.1 * t);
    return pose;
  });
}

TEST(LiveSystem, FeelsASceneWithADeviceOfTheCallers) {
  LiveSystem system(plane_config(), own_device());
  EXPECT_EQ(system.device_kind(), "external");
  EXPECT_EQ(system.device().name, "own");
  LiveView view;
  system.start({&view});
  EXPECT_TRUE(comes_true([&] {
    view.update();
    return view.totals().force_max > 0.5;
  }));
  system.stop();
}

// A rod of 400 mm, in a world twice as large as the hand's, resists turns as far as the device can hold that.
TEST(LiveSystem, MakesAProxyThatTurnsAsTheDeviceNeeds) {
  DeviceCapabilities can;
  can.name = "six axes";
  can.force_max = 10.0;
  can.torque_max = 1.0;
  can.actuated.rotation = 3;
  LiveConfig config = plane_config();
  config.tool = Tool(Eigen::Vector3d(0.2, 0.02, 0.02));
  config.device.map.scale = 2.0;
  LiveSystem system(config, std::make_unique<ScriptedDevice>(can, [](double t) {
                      Pose pose;
                      pose.position.z() = std::max(0.009, 0.03 - 0.05 * t);
                      return pose;
                    }));
  LiveView view;
  system.start({&view});
  EXPECT_TRUE(comes_true([&] {
    view.update();
    return view.newest().felt.stiffness > 0.0;
  }));
  const ForceOutput& felt = view.newest().felt;
  const double arm = 2.0 * ServoTick::longest_arm(can, config.force.proxy.stiffness, 1e-3);
  EXPECT_NEAR(std::sqrt(felt.angular_stiffness / felt.stiffness), arm, 1e-9);
  EXPECT_LT(arm, ProxyForce::kTurning * config.tool.gyration());
  system.stop();
}

TEST(LiveSystem, ChangesWhatIsFeltAndNothingElse) {
  LiveSystem system(plane_config(), own_device());
  LiveView view;
  system.start({&view});
  const auto before = system.felt();
  system.change([](LiveConfig& c) {
    c.tool = Tool(Eigen::Vector3d(0.03, 0.03, 0.03));
    c.force.model = ForceModelKind::kField;
    c.scene.path = "elsewhere.ply";
    c.loop.rate = 10.0;
    c.device.profile = "falcon";
    c.gateway.port = 1;
    c.force.materials = "wood.toml";
  });
  EXPECT_TRUE(comes_true([&] { return system.felt() != before; }));
  EXPECT_EQ(system.message(), "");
  EXPECT_EQ(system.felt()->tool(), Tool(Eigen::Vector3d(0.03, 0.03, 0.03)));
  LiveConfig expected = plane_config();
  expected.tool = Tool(Eigen::Vector3d(0.03, 0.03, 0.03));
  expected.force.model = ForceModelKind::kField;
  EXPECT_EQ(system.settings(), expected);
  system.stop();
}

TEST(LiveSystem, OpensAnotherSceneAndForgetsWhatWasOfTheOldOne) {
  const TemporaryFile ball(ply_bytes(make_scene(*make_surface("sphere"), {}), "ball"), "ball.ply");
  LiveConfig config = plane_config();
  config.scene.registration.scale = 2.0;
  config.scene.filter.crop_box =
      Eigen::AlignedBox3d(Eigen::Vector3d::Constant(-9), Eigen::Vector3d::Constant(9));
  LiveSystem system(config, own_device());
  LiveView view;
  system.start({&view});
  EXPECT_EQ(system.felt()->path(), plane());
  system.open_scene(ball.path());
  ASSERT_TRUE(comes_true([&] { return system.felt()->path() == ball.path(); }));
  EXPECT_EQ(system.message(), "");
  EXPECT_EQ(system.felt()->index()->size(), make_scene(*make_surface("sphere"), {}).size());
  const SceneConfig scene = system.settings().scene;
  EXPECT_EQ(scene.registration.scale, 1.0);
  EXPECT_FALSE(scene.filter.crop_box);
  EXPECT_FALSE(scene.scale_known || scene.frame_known);
  system.open_scene("");  // the built-in one, whose size is known
  ASSERT_TRUE(comes_true([&] { return system.felt()->path().empty(); }));
  EXPECT_TRUE(system.settings().scene.scale_known);
  system.stop();
}

TEST(LiveSystem, KeepsTheSceneWhereTheOtherCannotBeRead) {
  const TemporaryFile broken("ply\nformat ascii 1.0\nelement vertex 1\n", "broken.ply");
  LiveSystem system(plane_config(), own_device());
  LiveView view;
  system.start({&view});
  const auto before = system.felt();
  for (const std::string& path : {broken.path(), std::string("/nowhere/scene.ply")}) {
    system.open_scene(path);
    EXPECT_TRUE(comes_true([&] { return testing::Value(system.message(), testing::HasSubstr(path)); }))
        << path;
    EXPECT_EQ(system.felt(), before);
    EXPECT_EQ(system.settings(), plane_config());
  }
  system.stop();
}

TEST(LiveSystem, IsChangedByOneThreadWhileAnotherChangeIsMade) {
  LiveSystem system(plane_config());
  LiveView view;
  system.start({&view});
  std::jthread other([&](const std::stop_token& end) {
    while (!end.stop_requested()) {
      system.change([](LiveConfig& c) { c.force.proxy.stiffness = 1100.0 - c.force.proxy.stiffness; });
      sleep_until(monotonic_now() + 1e-4);
    }
  });
  for (const double radius : {0.02, 0.03}) {
    const Tool ball(Eigen::Vector3d::Constant(radius));
    system.change([&](LiveConfig& c) { c.tool = ball; });
    EXPECT_TRUE(comes_true([&] { return system.felt()->tool() == ball; }));
  }
  other.request_stop();
  other.join();
  system.stop();
}

TEST(LiveSystem, KeepsItsSettingsWhereAnEditFails) {
  LiveSystem system(plane_config(), own_device());
  LiveView view;
  system.start({&view});
  EXPECT_THROW(system.change([](LiveConfig& c) {
    c.force.proxy.stiffness = 1.0;
    throw Error("no");
  }),
               Error);
  EXPECT_EQ(system.settings(), plane_config());
  system.stop();
}

/// A system of which a change that leaves nothing to touch is held up while it is made.
class HeldUp {
 public:
  explicit HeldUp(const LiveConfig& config = plane_config(),
                  std::unique_ptr<HapticDevice> device = own_device())
      : system(config, std::move(device), [this](const std::string&) {
          if (!holds) return;
          is_held = true;
          while (holds) sleep_until(monotonic_now() + 1e-3);
        }) {
    system.start({&view});
  }
  ~HeldUp() { holds = false; }
  HeldUp(const HeldUp&) = delete;
  HeldUp& operator=(const HeldUp&) = delete;
  double force() {
    view.update();
    return view.newest().sent.force.norm();
  }

  std::atomic<bool> holds = false, is_held = false;
  LiveView view;
  LiveSystem system;
};

void set_stiffness(LiveSystem& system, double stiffness) {
  system.change([=](LiveConfig& c) { c.force.proxy.stiffness = stiffness; });
}

TEST(LiveSystem, TheStiffnessTakesEffectWhileASceneLoadsAndStaysIfThatFails) {
  HeldUp held;
  const TemporaryFile other(ply_bytes(make_scene(*make_surface("sphere"), {}), "ball"), "ball.ply");
  const auto before = held.system.felt();
  held.system.change([](LiveConfig& c) { c.scene.filter.opacity_min = 1.0; });
  EXPECT_TRUE(comes_true([&] { return held.system.felt() != before && held.system.busy().empty(); }));
  held.holds = true;
  held.system.open_scene(other.path());
  EXPECT_TRUE(comes_true([&] { return held.is_held.load(); }));
  set_stiffness(held.system, 100.0);
  EXPECT_EQ(held.system.tick().wanted_gain(), 100.0 / 500.0);
  EXPECT_EQ(held.system.settings().scene.path, other.path());
  held.holds = false;
  EXPECT_TRUE(comes_true([&] { return held.system.settings().scene.path == plane(); }));
  EXPECT_THAT(held.system.message(), testing::HasSubstr("no Gaussian passes"));
  EXPECT_EQ(held.system.settings().force.proxy.stiffness, 100.0);
  EXPECT_TRUE(comes_true([&] { return held.system.busy().empty(); }));
  EXPECT_EQ(held.system.tick().wanted_gain(), 100.0 / 500.0);
  EXPECT_THAT(held.system.message(), testing::HasSubstr("no Gaussian passes"))
      << "of the stiffness, which is fine";
  held.system.stop();
}

TEST(LiveSystem, SaysHowARecordingIsMadeByWhatIsFeltAndNotByWhatIsWanted) {
  HeldUp held;
  held.holds = true;
  const auto made = [&] { return to_toml(held.system.provenance("run")); };
  held.system.change([](LiveConfig& c) { c.scene.filter.opacity_min = 1.0; });
  EXPECT_TRUE(comes_true([&] { return held.is_held.load(); }));
  EXPECT_THAT(made(), testing::HasSubstr("opacity-min = 0.1"));
  held.holds = false;
  EXPECT_TRUE(comes_true([&] { return testing::Value(made(), testing::HasSubstr("opacity-min = 1")); }))
      << made();
  held.system.stop();
}

TEST(LiveSystem, ASceneWhoseFileWasReplacedIsNotFilteredAnew) {
  const TemporaryFile file(ply_bytes(make_scene(*make_surface("plane"), {}), "plane"), "scene.ply");
  LiveConfig config = plane_config();
  config.scene.path = file.path();
  LiveSystem system(config, own_device());
  LiveView view;
  system.start({&view});
  const auto before = system.felt();
  {
    const TemporaryFile other(ply_bytes(make_scene(*make_surface("sphere"), {}), "ball"), "ball.ply");
    std::filesystem::rename(other.path(), file.path());
  }
  system.change([](LiveConfig& c) { c.scene.filter.opacity_min = 0.2; });
  EXPECT_TRUE(comes_true([&] { return !system.message().empty(); }));
  EXPECT_THAT(system.message(), testing::HasSubstr("has changed since it was opened"));
  EXPECT_EQ(system.felt(), before);
  EXPECT_EQ(system.settings(), config);
  system.stop();
}

TEST(LiveSystem, AStiffnessOfZeroCanBeRaised) {
  LiveConfig config = plane_config();
  config.force.proxy.stiffness = 0.0;
  // A spring that grows under load takes nothing that the hand has not put in: the hand must let go once.
  const auto to_and_fro = [](double t) {
    Pose pose;
    pose.position.z() = 0.05 - 0.012 * std::abs(std::sin(2.0 * t));
    return pose;
  };
  HeldUp held(config, std::make_unique<ScriptedDevice>(own_device()->capabilities(), to_and_fro));
  EXPECT_TRUE(comes_true([&] {
    held.view.update();
    return held.view.newest().contacts > 0 && held.view.newest().state == GovernorState::kActive;
  }));
  EXPECT_EQ(held.force(), 0.0);
  set_stiffness(held.system, 500.0);
  EXPECT_TRUE(comes_true([&] { return held.force() > 0.3; }));
  held.system.stop();
}

/// A handle at rest above the plane, whose driver does not do all that it should.
struct OddDevice : HapticDevice {
  OddDevice() {
    can.name = "odd";
    can.force_max = 10.0;
  }
  const DeviceCapabilities& capabilities() const override { return can; }
  bool read(double t, DeviceReading& reading) override {
    reading.t = t;
    reading.pose.position.z() = 0.1;
    return true;
  }
  void write(const Wrench&) override {}

  DeviceCapabilities can;
};

TEST(LiveSystem, DoesNotStartADeviceThatIsNotEnabled) {
  struct NeverEnabled final : OddDevice {
    void enable() override {}
  };
  LiveSystem system(plane_config(), std::make_unique<NeverEnabled>());
  EXPECT_THAT(message_of<Error>([&] { system.start({}); }),
              testing::HasSubstr("'odd': its status is open, not enabled"));
}

TEST(LiveSystem, TurnsOffMotorsThatHaveNotStarted) {
  struct Motors final : OddDevice {
    Motors(int& enables_, std::atomic<int>& stops_) : enables(enables_), stops(stops_) {}
    void enable() override {
      ++enables;
      HapticDevice::enable();
    }
    void stop() noexcept override { ++stops; }
    int& enables;
    std::atomic<int>& stops;
  };
  int enables = 0;
  std::atomic<int> stops = 0;
  LiveSystem system(plane_config(), std::make_unique<Motors>(enables, stops));
  system.enable();
  EXPECT_EQ(system.device().name, "odd");
  system.stop_motors();
  EXPECT_EQ(stops, 1);
  system.enable();
  system.start({});
  system.stop_motors();
  EXPECT_GE(stops, 2);
  EXPECT_EQ(enables, 1);
}

// A signal that comes before the loop runs is not lost.
TEST(LiveSystem, HasNoForceIfItWasStoppedBeforeItStarted) {
  LiveView view;
  LiveSystem system(plane_config(), std::make_unique<OddDevice>());
  system.enable();
  system.stop_force();
  system.start({&view});
  const auto is = [&](Fault fault) {
    return comes_true([&] {
      view.update();
      return view.newest().fault == fault;
    });
  };
  EXPECT_TRUE(is(Fault::kEmergencyStop));
  system.resume();
  EXPECT_TRUE(is(Fault::kNone));
}

// As by a page whose gateway is still there while all ends.
TEST(LiveSystem, IsNotResumedOnceItEnds) {
  for (const Fault why : {Fault::kEnded, Fault::kRecorder}) {
    LiveView view;
    LiveSystem system(plane_config(), std::make_unique<OddDevice>());
    system.start({&view});
    const auto is = [&](GovernorState state) {
      view.update();
      return view.newest().state == state;
    };
    EXPECT_TRUE(comes_true([&] { return is(GovernorState::kActive); }));
    system.stop_force(why);
    EXPECT_TRUE(comes_true([&] { return is(GovernorState::kStopped); }));
    system.resume();
    sleep_until(monotonic_now() + 0.5);
    EXPECT_TRUE(is(GovernorState::kStopped)) << traits(why).name;
  }
}

/// A handle above the plane that goes where it is told, under a hand that pushes it along x with 40 N.
struct PushedHandle final : MotionDevice {
  struct Told {
    double t = 0.0, velocity = 0.0;  ///< along x
  };
  PushedHandle() {
    can.name = "pushed";
    can.force_max = 100.0;
    can.torque_max = 10.0;
    can.actuated = {3, 3};
    told.reserve(100'000);
    at.position.z() = 0.5;
  }
  const DeviceCapabilities& capabilities() const override { return can; }
  bool read(double t, MotionReading& reading) override {
    constexpr double kTares = 1.2;  // s
    now = t;
    reading = {t, at, {}, {}, t};
    if (t > kTares) reading.user.force.x() = 40.0;
    return true;
  }
  MotionAnswer move(const MotionSetpoint& motion, double) override {
    at = motion.pose;
    if (told.size() < told.capacity()) told.push_back({now, motion.velocity.linear.x()});
    speed = motion.velocity.linear.x();
    return {motion};
  }

  DeviceCapabilities can;
  DevicePose at;
  double now = 0.0;
  std::vector<Told> told;
  std::atomic<double> speed = 0.0;
};

/// A system with such a handle.
struct PushedSystem {
  PushedSystem() : PushedSystem(std::make_unique<PushedHandle>()) {}
  explicit PushedSystem(std::unique_ptr<PushedHandle> own)
      : handle(*own), system(plane_config(), std::make_unique<AdmittanceLoop>(std::move(own), options())) {
    system.start({});
  }
  static AdmittanceLoopOptions options() {
    AdmittanceLoopOptions options;
    options.margin = 0.0;
    options.safety = MotionSafety::of(PushedHandle().can, options.limits, options.period);
    options.safety->late_max = options.safety->stale_after = 1e3;  // a busy machine is not what is tested
    options.safety->jump = options.safety->following_max = 1e3;
    return options;
  }
  bool moves() {
    return comes_true([&] { return handle.speed > 1.0; });
  }
  PushedHandle& handle;
  LiveSystem system;
};

/// Expects every setpoint within the limit of acceleration, and the last one at rest.
void expect_rest(const PushedHandle& handle) {
  const std::vector<PushedHandle::Told>& told = handle.told;
  ASSERT_GT(told.size(), 2U);
  EXPECT_EQ(told.back().velocity, 0.0);
  for (std::size_t k = 1; k < told.size(); ++k)
    EXPECT_LE(std::abs(told[k].velocity - told[k - 1].velocity),
              MotionLimits().acceleration * (told[k].t - told[k - 1].t) * (1.0 + 1e-9))
        << k;
}

TEST(LiveSystem, BringsAHandleThatIsMovedToRestBeforeItHasStopped) {
  PushedSystem pushed;
  ASSERT_TRUE(pushed.moves());
  pushed.system.stop();
  expect_rest(pushed.handle);
}

TEST(LiveSystem, BrakesAHandleThatIsMovedWhateverEndsTheRun) {
  for (const Fault why : {Fault::kEnded, Fault::kRecorder, Fault::kEmergencyStop}) {
    PushedSystem pushed;
    ASSERT_TRUE(pushed.moves()) << traits(why).name;
    pushed.system.stop_force(why);
    EXPECT_TRUE(comes_true([&] { return pushed.handle.speed == 0.0; })) << traits(why).name;
    pushed.system.stop();
    expect_rest(pushed.handle);
  }
}

TEST(LiveSystem, LetsAHandleBeMovedInAPause) {
  PushedSystem pushed;
  ASSERT_TRUE(pushed.moves());
  pushed.system.stop_force(Fault::kPaused);
  sleep_until(monotonic_now() + 0.4);  // longer than it would brake
  EXPECT_GT(pushed.handle.speed, 1.0);
  pushed.system.stop();
  expect_rest(pushed.handle);
}

LiveConfig giant_config() {
  LiveConfig config = plane_config();
  config.device.kind = DeviceKind::kGiant;
  return config;
}

/// Changes the tool as well, since that shows when the change of the stiffness has been made.
void set_stiffness_and_tool(LiveSystem& system, double stiffness, const Tool& tool) {
  system.change([&](LiveConfig& c) {
    c.force.proxy.stiffness = stiffness;
    c.tool = tool;
  });
}

TEST(LiveSystem, KeepsTheChainOfAGiantWhoseFileHasGone) {
  auto chain = std::make_unique<TemporaryFile>(std::string(giant_chain_text()), "chain.toml");
  LiveConfig config = giant_config();
  config.device.chain = chain->path();
  LiveSystem system(config);
  chain.reset();
  system.start({});
  const Tool ball(Eigen::Vector3d::Constant(0.03));
  set_stiffness_and_tool(system, 600.0, ball);
  EXPECT_TRUE(comes_true([&] { return system.felt()->tool() == ball || !system.message().empty(); }));
  EXPECT_EQ(system.message(), "");
  EXPECT_EQ(system.settings().force.proxy.stiffness, 600.0);
  system.stop();
}

TEST(LiveSystem, RevertsAStiffnessWithWhichAGiantIsUnstable) {
  LiveConfig config = giant_config();
  config.device.virtual_damping = GiantSetup::kVirtualDamping;
  LiveSystem system(config);
  system.start({});
  set_stiffness(system, 5000.0);
  EXPECT_TRUE(comes_true([&] { return !system.message().empty(); }));
  EXPECT_THAT(system.message(), testing::HasSubstr("not stable at 5000 N/m"));
  EXPECT_EQ(system.settings().force.proxy.stiffness, 500.0);
  EXPECT_EQ(system.tick().wanted_gain(), 1.0);
  set_stiffness(system, 400.0);
  EXPECT_TRUE(comes_true([&] { return system.message().empty(); }));
  EXPECT_EQ(system.settings().force.proxy.stiffness, 400.0);
  system.stop();
}

TEST(LiveSystem, StartsOnce) {
  LiveSystem system(plane_config(), own_device());
  system.start({});
  EXPECT_THAT(message_of<Error>([&] { system.start({}); }), testing::HasSubstr("runs already"));
  system.stop();
  EXPECT_THAT(message_of<Error>([&] { system.start({}); }), testing::HasSubstr("was stopped"));
  LiveSystem never(plane_config(), own_device());
  never.stop();
  EXPECT_THAT(message_of<Error>([&] { never.start({}); }), testing::HasSubstr("was stopped"));
}

TEST(LiveSystem, IsNotChangedBeforeTheStart) {
  LiveSystem system(plane_config(), own_device());
  EXPECT_THAT(message_of<Error>([&] { set_stiffness(system, 100.0); }),
              testing::HasSubstr("has not started"));
  EXPECT_THAT(message_of<Error>([&] { system.open_scene(""); }), testing::HasSubstr("has not started"));
  system.stop_force();
  system.resume();
  EXPECT_EQ(system.settings(), plane_config());
}

TEST(LiveSystem, AnEditMayAskForTheSettingsAndNotChangeThemOtherwise) {
  LiveSystem system(plane_config(), own_device());
  system.start({});
  system.change(
      [&](LiveConfig& c) { c.force.proxy.stiffness = 2.0 * system.settings().force.proxy.stiffness; });
  EXPECT_EQ(system.settings().force.proxy.stiffness, 1000.0);
  EXPECT_THAT(message_of<Error>([&] { system.change([&](LiveConfig&) { set_stiffness(system, 100.0); }); }),
              testing::HasSubstr("change its argument only"));
  system.stop();
}

TEST(LiveSystem, ReportsWhatItsCallbacksThrow) {
  std::atomic<bool> throws = false;
  LiveSystem system(plane_config(), own_device(), [&](const std::string&) {
    if (throws) throw 1;
  });
  system.on_scene = [](const SharedScene&) { throw std::runtime_error("no window to draw it in"); };
  system.start({});
  const auto before = system.felt();
  system.change([](LiveConfig& c) { c.scene.registration.scale = 2.0; });
  EXPECT_TRUE(comes_true([&] { return !system.message().empty(); }));
  EXPECT_THAT(system.message(), testing::HasSubstr("no window to draw it in"));
  EXPECT_NE(system.felt(), before);
  EXPECT_EQ(system.settings().scene.registration.scale, 2.0);
  throws = true;
  system.change([](LiveConfig& c) { c.scene.filter.opacity_min = 1.0; });  // which it would like to tell
  EXPECT_TRUE(comes_true([&] { return !system.message().empty(); }));
  EXPECT_THAT(system.message(), testing::HasSubstr("unknown reason"));
  EXPECT_EQ(system.settings().scene.filter.opacity_min, 0.1);
  system.stop();
}

TEST(LiveSystem, SaysWhatIsMissing) {
  LiveConfig config = plane_config();
  config.scene.path = "/nowhere/scene.ply";
  EXPECT_THAT(message_of<Error>([&] { LiveSystem system(config, own_device()); }),
              testing::HasSubstr("/nowhere/scene.ply"));
  config = plane_config();
  config.device.kind = DeviceKind::kPlayback;
  EXPECT_THAT(message_of<Error>([&] { LiveSystem system(config); }),
              testing::HasSubstr("needs --trajectory"));
  config.device.kind = DeviceKind::kClient;
  config.device.profile = "spoon";
  EXPECT_THAT(message_of<Error>([&] { LiveSystem system(config); }),
              testing::HasSubstr("profile: is not one of"));
}

TEST(LiveSystem, RefusesSettingsThatPullOrHaveNoMeaning) {
  LiveConfig config = plane_config();
  config.loop.rate = 0.0;
  EXPECT_THAT(message_of<Error>([&] { LiveSystem system(config, own_device()); }),
              testing::HasSubstr("rate: 0 is not in"));
  LiveSystem system(plane_config(), own_device());
  system.start({});
  for (const double bad : {-500.0, std::nan("")}) {
    EXPECT_THAT(message_of<Error>([&] { set_stiffness(system, bad); }), testing::HasSubstr("stiffness: "));
    EXPECT_THAT(
        message_of<Error>([&] { system.change([=](LiveConfig& c) { c.scene.registration.scale = bad; }); }),
        testing::HasSubstr("scale: "));
  }
  EXPECT_EQ(system.settings(), plane_config());
  EXPECT_EQ(system.tick().wanted_gain(), 1.0);
  system.stop();
}

TEST(LiveSystem, TellsWhatAPersonShouldKnow) {
  LiveConfig config = plane_config();
  config.scene.filter.opacity_min = 1.0;
  std::vector<std::string> told;
  LiveSystem system(config, own_device(), [&](const std::string& line) { told.push_back(line); });
  EXPECT_THAT(told, testing::Contains(testing::HasSubstr("no Gaussian passes the filter")));
}

TEST(LiveSystem, TellsOfAToolInMillimetresAndOfNoneInMetres) {
  for (const double unit : {1.0, 1e3}) {
    LiveConfig config = plane_config();
    config.tool = Tool(unit * Eigen::Vector3d(0.1, 0.1, 0.02));
    std::vector<std::string> told;
    LiveSystem system(config, own_device(), [&](const std::string& line) { told.push_back(line); });
    const auto line = testing::Contains(testing::HasSubstr("the tool is 100 m large"));
    const auto any = testing::Contains(testing::HasSubstr("m large"));
    if (unit > 1.0) {
      EXPECT_THAT(told, line);
    } else {
      EXPECT_THAT(told, testing::Not(any));
    }
  }
}

}  // namespace
}  // namespace palpate::test

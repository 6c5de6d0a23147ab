// Several hands over one scene: what one feels does not depend on the others, whatever befalls those.
#include <palpate/live/live_hands.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/device/testing/scripted_device.h>
#include <palpate/servo/live_view.h>

#include <support/live_scene.h>

namespace palpate::test {
namespace {

using testing::HasSubstr;

constexpr int kSteps = 400;
/// Places with a force that are looked at: of one that is alone nearly all.
constexpr std::size_t kEnough = 150, kNearlyAll = 250;

DeviceCapabilities capabilities() {
  DeviceCapabilities can;
  can.name = "own";
  can.force_max = 10.0;
  can.damping_source = DampingSource::kMeasured;
  can.damping =
      50.0;  // with which the springs here are passive however late a busy machine is: no gain below 1
  return can;
}

/// Where a handle is at a step: to and fro between above the plane and down in it.
Pose pose_at(int step) {
  const int there = step % (2 * kSteps), k = std::min(there, 2 * kSteps - there);
  Pose pose;
  pose.position = {1e-5 * k, 0.0, 0.045 - 0.008 * std::min(1.0, k / 200.0)};
  return pose;
}

/// A handle that goes a step a reading, whatever time has passed: what is felt does not depend on the
/// machine.
class Stepper final : public HapticDevice {
 public:
  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double t, DeviceReading& reading) override {
    reading = {t, DevicePose(pose_at(step_++)), {}, 0};
    return true;
  }
  void write(const Wrench&) override {}

 private:
  DeviceCapabilities capabilities_ = test::capabilities();
  int step_ = 0;
};

/// As that, until its driver throws, or hangs again and again for longer than the loop's watchdog waits.
class Breaker final : public HapticDevice {
 public:
  enum class How { kThrows, kHangs };
  explicit Breaker(How how) : how_(how) {}
  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double t, DeviceReading& reading) override {
    if (++step_ > kSteps / 2) {
      if (how_ == How::kThrows) throw Error("the cable burns");
      sleep_until(monotonic_now() + 0.3);
    }
    reading = {t, DevicePose(pose_at(step_)), {}, 0};
    return true;
  }
  void write(const Wrench&) override {}

 private:
  How how_;
  DeviceCapabilities capabilities_ = test::capabilities();
  int step_ = 0;
};

/// The wrenches of the model that are none of zero, by the tool's way along x, which no two places share.
class Felt final : public TickObserver {
 public:
  void see(const TickRecord& record, const TickTimes&) override {
    const std::scoped_lock lock(mutex_);
    if (!record.felt.wrench.force.isZero(0.0)) all_.emplace(record.tool.position.x(), record.felt.wrench);
  }
  std::map<double, Wrench> all() const {
    const std::scoped_lock lock(mutex_);
    return all_;
  }
  bool has(std::size_t places) const { return all().size() >= places; }
  void forget() {
    const std::scoped_lock lock(mutex_);
    all_.clear();
  }

 private:
  mutable std::mutex mutex_;
  std::map<double, Wrench> all_;
};

/// A function of the pose alone, so that two runs may be compared bit by bit.
LiveConfig field_config(const Tool& tool = {}) {
  LiveConfig config = plane_config();
  config.tool = tool;
  config.force.model = ForceModelKind::kField;
  config.force.proxy.stiffness = 100.0;
  return config;
}

HandSetup hand(const std::string& name, const LiveConfig& config, std::unique_ptr<HapticDevice> device) {
  return {name, config, std::move(device)};
}

template <class... Setups>
std::vector<HandSetup> setups(Setups... each) {
  std::vector<HandSetup> all;
  (all.push_back(std::move(each)), ...);
  return all;
}

std::map<double, Wrench> felt_alone(const LiveConfig& config) {
  LiveSystem system(config, std::make_unique<Stepper>());
  Felt felt;
  system.start({&felt});
  EXPECT_TRUE(comes_true([&] { return felt.has(kNearlyAll); }));
  system.stop();
  return felt.all();
}

/// Where both felt something: a busy machine may stop a force for a while.
void expect_same(const std::map<double, Wrench>& a, const std::map<double, Wrench>& b) {
  std::size_t compared = 0;
  for (const auto& [at, wrench] : a) {
    const auto other = b.find(at);
    if (other == b.end()) continue;
    ++compared;
    EXPECT_EQ(wrench.force, other->second.force) << at;
    EXPECT_EQ(wrench.torque, other->second.torque) << at;
  }
  EXPECT_GT(compared, kEnough / 4);
}

const Tool& large_ball() {
  static const Tool tool(Eigen::Vector3d::Constant(0.042));
  return tool;
}

TEST(LiveHands, EachFeelsWhatItWouldFeelAlone) {
  const auto first_alone = felt_alone(field_config()), ball_alone = felt_alone(field_config(large_ball()));
  LiveHands hands(setups(hand("", field_config(), std::make_unique<Stepper>()),
                         hand("ball", field_config(large_ball()), std::make_unique<Stepper>())));
  EXPECT_EQ(hands.all()[1].system->scene().index, hands.first().scene().index);
  Felt first, other;
  hands.start({{&first}, {&other}});
  EXPECT_TRUE(comes_true([&] { return first.has(kEnough) && other.has(kEnough); }));
  hands.stop();
  expect_same(first_alone, first.all());
  expect_same(ball_alone, other.all());
  EXPECT_NE(first_alone.rbegin()->second.force, ball_alone.rbegin()->second.force);
}

struct Mishap {
  const char* name;
  std::function<std::unique_ptr<HapticDevice>()> device;
  const char* says;  ///< of itself
};

class LiveHandsMishap : public testing::TestWithParam<Mishap> {};

TEST_P(LiveHandsMishap, OfOneHandLeavesTheOthersAsTheyAre) {
  const auto alone = felt_alone(field_config());
  LiveHands hands(setups(hand("", field_config(), std::make_unique<Stepper>()),
                         hand("broken", field_config(), GetParam().device()),
                         hand("last", field_config(), std::make_unique<Stepper>())));
  Felt first, last;
  LiveView broken;
  hands.start({{&first}, {&broken}, {&last}});
  EXPECT_TRUE(comes_true([&] {
    broken.update();
    return broken.newest().t > 0.5 && broken.newest().state == GovernorState::kStopped;
  }));
  EXPECT_EQ(hands.all()[1].system->device_fault(), GetParam().says);
  EXPECT_EQ(hands.first().device_fault(), "");
  for (Felt* felt : {&first, &last}) felt->forget();
  EXPECT_TRUE(comes_true([&] { return first.has(kEnough) && last.has(kEnough); }));
  hands.stop();
  expect_same(alone, first.all());
  expect_same(alone, last.all());
}

std::unique_ptr<HapticDevice> scripted(DeviceFault fault) {
  const auto path = [](double t) { return pose_at(static_cast<int>(1e3 * t)); };
  return std::make_unique<ScriptedDevice>(
      capabilities(), path, std::vector{ScriptedFault{0.2, std::numeric_limits<double>::infinity(), fault}});
}

INSTANTIATE_TEST_SUITE_P(
    Devices, LiveHandsMishap,
    testing::Values(
        Mishap{"Throws", [] { return std::make_unique<Breaker>(Breaker::How::kThrows); }, "the cable burns"},
        Mishap{"Hangs", [] { return std::make_unique<Breaker>(Breaker::How::kHangs); }, ""},
        Mishap{"IsUnplugged", [] { return scripted(DeviceFault::kUnplugged); }, "it is not plugged in"},
        Mishap{"IsSilent", [] { return scripted(DeviceFault::kSilent); }, ""},
        Mishap{"SaysNaN", [] { return scripted(DeviceFault::kNan); }, ""}),
    [](const auto& mishap) { return mishap.param.name; });

/// Its driver never returns from the read() after `steps`.
class Hung final : public HapticDevice {
 public:
  explicit Hung(int steps) : steps_(steps) {}
  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double t, DeviceReading& reading) override {
    while (++step_ > steps_) sleep_until(monotonic_now() + 10.0);
    reading = {t, DevicePose(pose_at(step_)), {}, 0};
    return true;
  }
  void write(const Wrench&) override {}

 private:
  int steps_;
  DeviceCapabilities capabilities_ = test::capabilities();
  int step_ = 0;
};

/// Tells that it was closed.
class Closes final : public HapticDevice {
 public:
  explicit Closes(bool& closed) : closed_(closed) {}
  const DeviceCapabilities& capabilities() const override { return stepper_.capabilities(); }
  bool read(double t, DeviceReading& reading) override { return stepper_.read(t, reading); }
  void write(const Wrench& wrench) override { stepper_.write(wrench); }
  void close() noexcept override {
    closed_ = true;
    HapticDevice::close();
  }

 private:
  bool& closed_;
  Stepper stepper_;
};

// Whatever ends the start of one: the observers of the others end with it.
TEST(LiveHands, AllEndWhereOneCannotStart) {
  struct Fails final : HapticDevice {
    const DeviceCapabilities& capabilities() const override {
      if (fails) throw std::bad_alloc();
      return stepper.capabilities();
    }
    bool read(double t, DeviceReading& reading) override { return stepper.read(t, reading); }
    void write(const Wrench&) override {}
    void enable() override {
      HapticDevice::enable();
      fails = true;
    }
    Stepper stepper;
    bool fails = false;
  };
  bool closed = false;
  LiveHands hands(setups(hand("", plane_config(), std::make_unique<Closes>(closed)),
                         hand("left", plane_config(), std::make_unique<Fails>())));
  EXPECT_THROW(hands.start({{}, {}}), std::bad_alloc);
  EXPECT_TRUE(closed);
}

TEST(LiveHands, NoneTicksBeforeAllAreEnabled) {
  struct Ticks final : HapticDevice {
    const DeviceCapabilities& capabilities() const override { return stepper.capabilities(); }
    bool read(double t, DeviceReading& reading) override {
      ++count;
      return stepper.read(t, reading);
    }
    void write(const Wrench& wrench) override { stepper.write(wrench); }
    Stepper stepper;
    std::atomic<int> count = 0;
  };
  struct Slow final : HapticDevice {
    explicit Slow(const Ticks& other_) : other(other_) {}
    const DeviceCapabilities& capabilities() const override { return other.capabilities(); }
    bool read(double, DeviceReading&) override { return false; }
    void write(const Wrench&) override {}
    void enable() override {
      sleep_until(monotonic_now() + 0.1);
      ticks = other.count;
      throw Error("no power");
    }
    const Ticks& other;
    int ticks = -1;
  };
  auto first = std::make_unique<Ticks>();
  auto last = std::make_unique<Slow>(*first);
  const Slow& slow = *last;
  LiveHands hands(
      setups(hand("", field_config(), std::move(first)), hand("last", field_config(), std::move(last))));
  EXPECT_EQ(message_of<Error>([&] { hands.start({{}, {}}); }), "hand last: no power");
  EXPECT_EQ(slow.ticks, 0);
}

TEST(LiveHands, EndWithoutTheOneWhoseDriverHangs) {
  bool closed = false;
  LiveView first, last;
  {
    LiveHands hands(setups(hand("", field_config(), std::make_unique<Hung>(300)),
                           hand("last", field_config(), std::make_unique<Closes>(closed))));
    hands.start({{&first}, {&last}});
    EXPECT_TRUE(comes_true([&] {
      first.update();
      return first.newest().fault == Fault::kStalled &&
             hands.all()[1].system->loop().statistics().ticks > 600;
    }));
    hands.stop();
    EXPECT_TRUE(hands.first().has_left_device());
    EXPECT_FALSE(hands.all()[1].system->has_left_device());
    EXPECT_EQ(hands.left_devices(),
              "the driver of own does not return; its motors were told to stop, and it is not closed");
    EXPECT_TRUE(closed);
    EXPECT_FALSE(hands.first().provenance("run").made.empty());
  }
  last.update();
  EXPECT_EQ(last.newest().state, GovernorState::kStopped);
}

TEST(LiveHands, EndWithoutTheOneThatCannotBeClosed) {
  struct NeverCloses final : HapticDevice {
    const DeviceCapabilities& capabilities() const override { return stepper.capabilities(); }
    bool read(double t, DeviceReading& reading) override { return stepper.read(t, reading); }
    void write(const Wrench& wrench) override { stepper.write(wrench); }
    void stop() noexcept override { stopped.store(true); }
    void close() noexcept override {
      while (true) sleep_until(monotonic_now() + 10.0);
    }
    Stepper stepper;
    std::atomic<bool> stopped = false;
  };
  bool closed = false;
  LiveView first, last;
  auto device = std::make_unique<NeverCloses>();
  const NeverCloses& hung = *device;  // which is left behind
  {
    LiveHands hands(setups(hand("", field_config(), std::move(device)),
                           hand("last", field_config(), std::make_unique<Closes>(closed))));
    hands.start({{&first}, {&last}});
    hands.stop();
    EXPECT_TRUE(hands.first().has_left_device());
    EXPECT_FALSE(hands.all()[1].system->has_left_device());
    EXPECT_TRUE(closed);
  }
  EXPECT_TRUE(hung.stopped.load());
}

TEST(LiveHands, StopsAllOrOne) {
  LiveHands hands(setups(hand("", field_config(), std::make_unique<Stepper>()),
                         hand("left", field_config(), std::make_unique<Stepper>())));
  LiveView first, left;
  hands.start({{&first}, {&left}});
  const auto fault = [](LiveView& view) {
    view.update();
    return view.newest().fault;
  };
  hands.all()[1].system->stop_force();
  EXPECT_TRUE(comes_true([&] { return fault(left) == Fault::kEmergencyStop; }));
  EXPECT_NE(fault(first), Fault::kEmergencyStop);
  hands.all()[1].system->resume();
  EXPECT_TRUE(comes_true([&] { return fault(left) == Fault::kNone; }));
  hands.stop_force();
  EXPECT_TRUE(comes_true(
      [&] { return fault(first) == Fault::kEmergencyStop && fault(left) == Fault::kEmergencyStop; }));
  hands.stop();
}

TEST(LiveHands, FollowTheFirstToAnotherScene) {
  const TemporaryFile sphere(ply_bytes(make_scene(*make_surface("sphere"), {}), "ball"), "ball.ply");
  LiveHands hands(setups(hand("", field_config(), std::make_unique<Stepper>()),
                         hand("ball", field_config(large_ball()), std::make_unique<Stepper>())));
  LiveSystem &first = hands.first(), &other = *hands.all()[1].system;
  LiveView view, other_view;
  hands.start({{&view}, {&other_view}});

  EXPECT_FALSE(hands.is_changing_scene());
  hands.open_scene(sphere.path());
  const bool opening = hands.is_changing_scene();
  EXPECT_TRUE(opening || other.felt()->path() == sphere.path());
  EXPECT_TRUE(comes_true([&] { return !hands.is_changing_scene(); }));
  EXPECT_EQ(first.felt()->path(), sphere.path());
  EXPECT_EQ(other.felt()->path(), sphere.path());
  EXPECT_EQ(other.felt()->index(), first.felt()->index());
  EXPECT_EQ(other.settings().scene, first.settings().scene);
  EXPECT_EQ(other.felt()->tool(), large_ball());

  first.change([](LiveConfig& config) { config.scene.registration.scale = 2.0; });
  const bool placing = hands.is_changing_scene();
  EXPECT_TRUE(placing || other.scene().config.registration.scale == 2.0);
  EXPECT_TRUE(comes_true([&] { return !hands.is_changing_scene(); }));
  EXPECT_EQ(other.scene().config.registration.scale, 2.0);
  EXPECT_TRUE(comes_true([&] { return other.settings().scene.registration.scale == 2.0; }));
  EXPECT_TRUE(comes_true([&] { return other.felt()->index() == first.felt()->index(); }));
  EXPECT_EQ(other.message(), "");

  // Its own settings are still its own.
  other.change([](LiveConfig& config) { config.force.proxy.friction = 0.3; });
  EXPECT_TRUE(
      comes_true([&] { return other.busy().empty() && other.settings().force.proxy.friction == 0.3; }));
  EXPECT_EQ(first.settings().force.proxy.friction, 0.0);
  EXPECT_EQ(other.felt()->index(), first.felt()->index());
  hands.stop();
}

TEST(LiveHands, TheSceneIsTheFirsts) {
  LiveHands hands(setups(hand("", field_config(), std::make_unique<Stepper>()),
                         hand("left", field_config(), std::make_unique<Stepper>())));
  LiveSystem& left = *hands.all()[1].system;
  LiveView view, left_view;
  hands.start({{&view}, {&left_view}});
  const LiveConfig before = left.settings();
  EXPECT_THAT(message_of<Error>(
                  [&] { left.change([](LiveConfig& config) { config.scene.filter.opacity_min = 0.9; }); }),
              HasSubstr("first hand"));
  EXPECT_THAT(message_of<Error>([&] { left.open_scene(""); }), HasSubstr("first hand"));
  EXPECT_EQ(left.settings(), before);
  hands.stop();
}

TEST(LiveHands, AHandThatNeedsItsSceneKeepsIt) {
  const TemporaryFile path("t,x,y,z\n0,0,0,0.1\n1,0,0,0.05\n", "path.csv");
  LiveConfig playback = field_config();
  playback.device.kind = DeviceKind::kPlayback;
  playback.device.trajectory = path.path();
  LiveHands hands(
      setups(hand("", field_config(), std::make_unique<Stepper>()), hand("film", playback, nullptr)));
  LiveView view, film;
  hands.start({{&view}, {&film}});
  EXPECT_THAT(message_of<Error>([&] { hands.open_scene(""); }),
              HasSubstr("hand film: a playback belongs to its scene"));
  EXPECT_EQ(hands.first().settings().scene.path, plane());
  hands.stop();
}

TEST(LiveHands, ArePlayedBackUntilTheEndOfTheLongestPlayback) {
  const auto of_seconds = [](double seconds) {
    return TemporaryFile("t,x,y,z\n0,0,0,0.1\n" + std::to_string(seconds) + ",0,0,0.05\n", "path.csv");
  };
  const TemporaryFile short_path = of_seconds(1.0), long_path = of_seconds(3.0);
  LiveConfig brief = field_config();
  brief.device.kind = DeviceKind::kPlayback;
  brief.device.trajectory = short_path.path();
  LiveConfig lengthy = brief;
  lengthy.device.trajectory = long_path.path();
  EXPECT_DOUBLE_EQ(
      LiveHands(setups(hand("", brief, nullptr), hand("left", lengthy, nullptr))).playback_length(), 3.0);
  EXPECT_DOUBLE_EQ(
      LiveHands(setups(hand("", lengthy, nullptr), hand("left", brief, nullptr))).playback_length(), 3.0);
  EXPECT_EQ(
      LiveHands(setups(hand("", lengthy, nullptr), hand("left", field_config(), std::make_unique<Stepper>())))
          .playback_length(),
      std::numeric_limits<double>::infinity());
}

TEST(LiveHands, SaysWhichHandCannotBe) {
  LiveConfig spoon = field_config();
  spoon.device.profile = "spoon";
  EXPECT_THAT(message_of<Error>([&] {
                LiveHands hands(setups(hand("", field_config(), std::make_unique<Stepper>()),
                                       hand("left", spoon, nullptr)));
              }),
              testing::StartsWith("hand left: "));
}

TEST(LiveHands, ANoteSaysWhoseItIs) {
  const TemporaryFile ball(ply_bytes(make_scene(*make_surface("sphere"), {}), "ball"), "ball.ply");
  LiveConfig bare = field_config();
  bare.scene.path = ball.path();
  bare.scene.filter.opacity_min = 1.0;  // there is nothing to explore
  std::vector<std::string> told;
  const auto tell = [&](const std::string& line) { told.push_back(line); };
  const auto calibrated = [] { return scripted(DeviceFault::kSilent); };
  LiveHands hands(setups(hand("", bare, calibrated()), hand("left", bare, calibrated())), tell);
  EXPECT_THAT(told, testing::ElementsAre(testing::StartsWith("warning: " + ball.path()),
                                         testing::StartsWith("note: own needs"),
                                         testing::StartsWith("note: hand left: own needs")));
}

}  // namespace
}  // namespace palpate::test

// The part of a node that knows nothing of its network, with a driver that presses on a plane, and a network
// of its own.
#include <node_recording.h>
#include <run_node.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/live/config_json.h>
#include <support/live_scene.h>

namespace palpate::node {
namespace {

using test::comes_true;
using testing::HasSubstr;

/// The driver, which presses once it has been free for long enough to be let. Outlives what uses it.
struct Driver {
  std::atomic<double> force = 0.0;  ///< that was sent last. Unit: [N].
  std::atomic<bool> hangs = false;  ///< when the device is closed
};

class Network final : public CrtkTransport {
 public:
  explicit Network(Driver& driver) : driver_(driver) {}
  ~Network() override { stop(); }
  void start(CrtkDevice& device) override {
    thread_ = std::thread([this, &device] { press(device); });
  }
  void stop() noexcept override {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
    while (driver_.hangs) sleep_until(monotonic_now() + 1e-3);
  }
  bool has_listener() override { return true; }
  std::uint64_t arrivals() override { return 1; }
  void send(const CrtkWrench& wrench, const std::string&) override {
    driver_.force = wrench.spatial.force.norm();
  }
  bool wants_local_model() override { return false; }
  void send_local_model(const LocalModel&, double) override {}
  void send_echo(std::uint64_t) override {}
  void say(const std::string&) override {}

 private:
  void press(CrtkDevice& device) const {
    Pose pose;
    pose.position.z() = 0.05;
    for (const double begin = monotonic_now(); !ends_; sleep_until(monotonic_now() + 1e-3)) {
      if (monotonic_now() > begin + 1.0) pose.position.z() = std::max(0.016, pose.position.z() - 1e-4);
      device.take_pose({0.0, "base", "/driver"}, pose);
    }
  }

  Driver& driver_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

/// Does nothing but what a test wants.
struct Sink final : NodeSink {
  ~Sink() override {
    if (at_end) at_end();
  }
  bool wants_contacts(std::size_t) const override { return false; }
  void publish_contacts(std::size_t, const std::vector<SinkMarker>&) override {}
  void publish_tool(std::size_t, const std::vector<SinkMarker>&) override {}
  void publish_transforms(const std::vector<SinkTransform>&) override {
    if (at_transforms) at_transforms();
  }
  void publish_diagnostics(const std::vector<SinkStatus>&) override {}
  void publish_centers(const std::vector<float>&) override {
    if (at_centers) at_centers();
  }
  std::function<void()> at_transforms, at_centers, at_end;
};

class NodeTest : public testing::Test {
 protected:
  NodeTest() {
    NodeHand hand;
    hand.live = test::plane_config();
    hand.live.tool = Tool(Eigen::Vector3d::Constant(0.02));
    hand.device.prefix = "/omni";
    hand.device.options.capabilities.name = "omni";
    hand.device.options.capabilities.force_max = 8.0;
    hand.device.options.capabilities.rate = 20.0;
    settings.hands.push_back(hand);
    settings.recordings = testing::TempDir();
  }

  /// Runs a node with that sink until `up` is false.
  void run(const std::function<void(Sink&)>& prepare, const std::function<bool()>& up) {
    run_node(settings,
             {[this](const std::string&, NodeNotices&) { return std::make_unique<Network>(driver); },
              [&](const NodeSettings&, const std::vector<SinkHand>& hands) {
                services = hands.front().services;
                auto sink = std::make_unique<Sink>();
                prepare(*sink);
                return sink;
              },
              up},
             notices);
  }

  Driver driver;
  NodeSettings settings;
  NodeNotices notices{"test"};
  NodeServices services;
};

TEST_F(NodeTest, LetsTheForceFallBeforeItsServicesEndAlsoAfterAnException) {
  bool has_fallen = false;
  const auto prepare = [&](Sink& sink) {
    sink.at_transforms = [&] {
      if (driver.force > 0.3) throw std::runtime_error("a defect");
    };
    sink.at_end = [&] {  // services that wait for a disk
      const double until = monotonic_now() + 2.0;
      while (driver.force > 0.0 && monotonic_now() < until) sleep_until(monotonic_now() + 1e-2);
      has_fallen = driver.force == 0.0;
    };
  };
  const double until = monotonic_now() + 60.0;
  EXPECT_THROW(run(prepare, [&] { return monotonic_now() < until; }), std::runtime_error);
  EXPECT_TRUE(has_fallen);
}

TEST_F(NodeTest, GoesOnIfThereIsNotEnoughMemoryToPublishTheScene) {
  int count = 0;
  const auto prepare = [&](Sink& sink) {
    sink.at_centers = [] { throw std::bad_alloc(); };
    sink.at_transforms = [&] { ++count; };
  };
  EXPECT_NO_THROW(run(prepare, [&] { return count < 3; }));
  EXPECT_THAT(notices.said().newest, HasSubstr("not enough memory to publish its centres and contacts"));
}

/// First number of the translation at the head of a recording.
double translation_of(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  constexpr std::string_view kKey = "# translate = [";
  while (std::getline(file, line))
    if (line.starts_with(kKey)) return std::stod(line.substr(kKey.size()));
  return std::numeric_limits<double>::quiet_NaN();
}

// However closely another placement is sent before or while it begins.
TEST_F(NodeTest, HasOnePlacementOfTheSceneInARecording) {
  std::atomic<bool> is_up = true;
  std::atomic<int> count = 0;
  const auto placed = [&] {
    return decode_json(services.get_parameters())["registration"]["translation"][0].get<double>();
  };
  int made = 0;
  std::thread client([&] {
    while (count < 3) sleep_until(monotonic_now() + 1e-3);
    constexpr double kStep = 5e-5;  // s; a recording begins within some milliseconds
    for (int k = 1; k <= 80; ++k) {
      std::thread other([&, begin = monotonic_now()] {
        sleep_until(begin + k * kStep);
        services.set_parameters(
            fmt::format(R"({{"registration": {{"translation": [{}, 0, 0]}}}})", 1e-4 * k));
      });
      std::string path;
      EXPECT_TRUE(comes_true([&] {
        if (!path.empty()) return true;
        const Answer answer = answer_of([&] { return services.record(true); });
        if (answer.success) path = answer.message;
        return answer.success;
      }));
      other.join();
      EXPECT_NEAR(translation_of(path), placed(), 1e-9) << k;
      services.record(false);
      std::filesystem::remove(path);
      ++made;
    }
    is_up = false;
  });
  run([&](Sink& sink) { sink.at_transforms = [&] { ++count; }; }, [&] { return is_up.load(); });
  client.join();
  EXPECT_EQ(made, 80);
}

TEST(NodeRecording, SaysHowManyTicksItLacksOnce) {
  const LiveSystem system(test::plane_config());
  RecorderOptions rows = recorder_options(system.device());
  rows.room = 4;
  NodeRecording recording(testing::TempDir(), "slow", system, rows);
  for (const bool by_service : {true, false}) {
    const std::string path = recording.set(true, [] {});
    TickRecord record;
    constexpr int kTicks = 10'000;  // before the writer looks again
    for (int k = 0; k < kTicks; ++k) {
      record.t = 1e-3 * k;
      recording.observer().see(record, {});
    }
    if (by_service) recording.set(false, {});
    const std::string said = by_service ? recording.look() : recording.close();
    EXPECT_THAT(said, testing::MatchesRegex(
                          "warning: the recording lacks [0-9]+ ticks: .*; the others are in " + path));
    EXPECT_EQ(recording.look(), "");
    std::filesystem::remove(path);
  }
}

TEST_F(NodeTest, SaysAtItsEndThatItsRecordingFailed) {
  std::string path;
  int count = 0;
  const auto prepare = [&](Sink& sink) {
    sink.at_transforms = [&] {
      if (++count == 3) path = services.record(true);
    };
    // The services have ended: nobody looks at the recording any more.
    sink.at_end = [&] { std::filesystem::remove(path); };
  };
  run(prepare, [&] { return count < 6; });
  EXPECT_THAT(notices.said().newest, HasSubstr("the recording has ended: " + path + ": was removed"));
}

TEST_F(NodeTest, GoesOnIfThereIsNotEnoughMemoryForAMessage) {
  int count = 0;
  const auto prepare = [&](Sink& sink) {
    sink.at_transforms = [&] {
      if (++count < 3) throw std::bad_alloc();
    };
  };
  EXPECT_NO_THROW(run(prepare, [&] { return count < 5; }));
  EXPECT_THAT(notices.said().newest, HasSubstr("not enough memory to publish"));
}

TEST_F(NodeTest, FailsIfADriverHangsWhenItIsClosed) {
  driver.hangs = true;
  int count = 0;
  const auto prepare = [&](Sink& sink) { sink.at_transforms = [&] { ++count; }; };
  try {
    run(prepare, [&] { return count < 3; });
    ADD_FAILURE() << "says nothing";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("the driver of omni does not return"));
  }
  driver.hangs = false;
  sleep_until(monotonic_now() + 0.2);  // what was left behind uses the driver
}

}  // namespace
}  // namespace palpate::node

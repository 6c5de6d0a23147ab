#include <palpate/servo/servo_loop.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <system_error>

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <pthread.h>

#include <palpate/study/procedural.h>

namespace {

/// Number of threads that are started until one is refused; 0: none is.
std::atomic<int> starts_until_refusal = 0;

}  // namespace

/// In place of the C library's: refuses a thread as the system does at its limit of tasks.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*work)(void*),
                              void* argument) {
  static const auto start = reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  if (starts_until_refusal > 0 && --starts_until_refusal == 0) return EAGAIN;
  return start(thread, attributes, work, argument);
}

namespace palpate {
namespace {

/// A handle that is nearly still; every `slow_every`-th reading takes `slow` seconds.
struct StillHandle final : HapticDevice {
  StillHandle() {
    can.force_max = 10.0;
    can.damping = 1.0;
  }
  const DeviceCapabilities& capabilities() const override { return can; }
  bool read(double t, DeviceReading& reading) override {
    ++reads;
    if (slow_every != 0 && reads % slow_every == 0) sleep_until(monotonic_now() + slow);
    reading = {t - age, DevicePose{}, Twist{}};
    reading.pose.position.x() = 0.5 + 1e-6 * std::sin(100.0 * t);
    return true;
  }
  void write(const Wrench& wrench) override {
    last = wrench.force.norm();
    if (stops > 0) last_after_stop = std::max(last_after_stop.load(), last.load());
  }
  void stop() noexcept override { ++stops; }

  DeviceCapabilities can;
  int reads = 0, slow_every = 0;
  double slow = 0.0;
  double age = 0.0;  ///< of its readings. Unit: [s].
  std::atomic<double> last = 0.0, last_after_stop = 0.0;
  std::atomic<int> stops = 0;
};

/// Pushes by one newton once it has been quiet for long enough to be let.
struct Push final : ForceModel {
  bool wants_contacts() const override { return false; }
  void reset() override { age = 0.0; }
  ForceOutput evaluate(const ForceInput& input) override {
    while (stands_still) sleep_until(monotonic_now() + 1e-3);
    age += input.dt;
    ForceOutput out;
    out.proxy = input.tool;
    out.wrench.force.x() = age > 0.8 ? 1.0 : 0.0;
    out.stiffness = kStiffness;
    return out;
  }
  static constexpr double kStiffness = 500.0;
  double age = 0.0;
  std::atomic<bool> stands_still = false;
};

/// Remembers when ticks were.
struct Watcher final : TickObserver {
  void see(const TickRecord& record, const TickTimes& times) override {
    if (count > 0 && !(record.t > last)) backwards = true;
    last = record.t;
    ++count;
    overruns = times.overruns;
    state = record.state;
    fault = record.fault;
    if (record.margin > 0.0) margin = record.margin;
  }
  int count = 0;
  double margin = 0.0;  ///< the last that was known
  double last = 0.0;
  bool backwards = false;
  std::uint64_t overruns = 0;
  GovernorState state = GovernorState::kWaiting;
  Fault fault = Fault::kNone;
};

class ServoLoopTest : public testing::Test {
 protected:
  ServoLoop::Options at(double rate) {
    ServoLoop::Options options;
    options.rate = rate;
    options.real_time = false;
    return options;
  }

  void wait_for_force() {
    const double begin = clock.now();
    while (device.last < 0.99 && clock.now() < begin + 60.0) clock.sleep_until(clock.now() + 1e-2);
    ASSERT_GE(device.last, 0.99) << to_string(watcher.state) << ' ' << traits(watcher.fault).name;
  }

  SceneIndex index{make_scene(*make_surface("sphere"), {}), {}, {}};
  ToolTracker contacts{index, Tool{}};
  StillHandle device;
  Push push;
  Watcher watcher;
  LoopClock clock;
};

// As many beats as fit the time, each either kept or counted as left out, whatever the machine does besides.
TEST_F(ServoLoopTest, EveryBeatIsATickOrAnOverrun) {
  ServoTick tick(device, {&push, &contacts});
  const double begin = clock.now();
  ServoLoop loop(tick, clock, {&watcher}, at(1000.0));
  clock.sleep_until(begin + 0.5);
  loop.stop();
  const double beats = (clock.now() - begin) / 1e-3;
  const auto counted = static_cast<double>(loop.statistics().ticks + loop.statistics().overruns);
  EXPECT_LE(counted, beats + 1.0);
  EXPECT_GE(counted, 0.7 * beats);  // the thread may begin late
  EXPECT_EQ(watcher.count, static_cast<int>(loop.statistics().ticks));
  EXPECT_FALSE(watcher.backwards);
}

TEST_F(ServoLoopTest, EndsWithAnExceptionIfTheSystemRefusesOneOfItsThreads) {
  for (const int which : {1, 2}) {
    ServoTick tick(device, {&push, &contacts});
    starts_until_refusal = which;
    EXPECT_THROW(ServoLoop(tick, clock, {&watcher}, at(1000.0)), std::system_error);
    EXPECT_EQ(starts_until_refusal, 0) << which;
  }
  clock.sleep_until(clock.now() + 0.1);
  EXPECT_EQ(watcher.count, 0) << "no tick has run";
}

TEST_F(ServoLoopTest, ATickThatTakesTooLongIsCountedAndSurvived) {
  device.slow_every = 50;
  device.slow = 5.5e-3;
  ServoTick tick(device, {&push, &contacts});
  ServoLoop loop(tick, clock, {&watcher}, at(1000.0));
  while (loop.statistics().ticks < 200) clock.sleep_until(clock.now() + 1e-2);
  loop.stop();
  EXPECT_GE(loop.statistics().overruns, 4U * 5U);  // each leaves five out, at least
  // What the last tick may have left out, it was not told any more.
  EXPECT_GE(watcher.overruns, 4U * 5U);
  EXPECT_LE(watcher.overruns, loop.statistics().overruns);
  EXPECT_GE(loop.statistics().whole.max(), 5.5e-3);
}

// A busy machine makes it later, never earlier.
TEST_F(ServoLoopTest, TheAgeOfReadingsCountsAsDelay) {
  constexpr double kPeriod = 1e-3, kAge = 5e-3;
  device.age = kAge;
  ServoTick tick(device, {&push, &contacts});
  ServoLoop loop(tick, clock, {&watcher}, at(1.0 / kPeriod));
  while (loop.statistics().ticks < 500) clock.sleep_until(clock.now() + 1e-2);
  loop.stop();
  const double bound = passive_stiffness(device.can.damping + ServoTick::kHandDamping, 0.0, kPeriod, kAge);
  EXPECT_GT(watcher.margin, 0.0);
  EXPECT_LT(watcher.margin, 1.05 * bound / Push::kStiffness);
}

// A model that does not come back: the device is stopped meanwhile, and what is written afterwards is of no
// force.
TEST_F(ServoLoopTest, ALoopThatStandsStillHasItsDeviceStopped) {
  ServoTick tick(device, {&push, &contacts});
  ServoLoop loop(tick, clock, {&watcher}, at(1000.0));
  ASSERT_NO_FATAL_FAILURE(wait_for_force());
  device.stops = 0;  // a busy machine may have held up the beginning
  device.last_after_stop = 0.0;
  push.stands_still = true;
  const double begin = clock.now();
  while (device.stops == 0 && clock.now() < begin + 10.0) clock.sleep_until(clock.now() + 1e-3);
  EXPECT_GE(device.stops, 1);
  push.stands_still = false;
  clock.sleep_until(clock.now() + 0.2);
  EXPECT_EQ(device.last, 0.0);
  EXPECT_EQ(device.last_after_stop, 0.0);
  loop.stop();
  EXPECT_EQ(device.last_after_stop, 0.0);
}

TEST_F(ServoLoopTest, EndsWithNoForce) {
  ServoTick tick(device, {&push, &contacts});
  ServoLoop loop(tick, clock, {&watcher}, at(1000.0));
  ASSERT_NO_FATAL_FAILURE(wait_for_force());
  loop.stop();
  EXPECT_EQ(device.last, 0.0);
}

TEST_F(ServoLoopTest, SaysWhatTheSystemDoesNotPermit) {
  ServoTick tick(device, {&push, &contacts});
  ServoLoop::Options options;
  options.priority.cpu = 1023;  // that is not there
  ServoLoop loop(tick, clock, {}, options);
  bool said = false;
  for (const std::string& line : loop.refused())
    said = said || line.find("processor 1023") != std::string::npos;
  EXPECT_TRUE(said);
}

}  // namespace
}  // namespace palpate

#include <palpate/gateway/client_hand.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>
#include <poll.h>

#include <palpate/gateway/tick_feed.h>
#include <palpate/geometry/rotation.h>

namespace palpate {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

DevicePose at(double x) { return {{x, 0, 0}, Quaterniond::Identity()}; }

struct ClientDeviceTest : testing::Test {
  ClientHand hand;
  ClientDevice device{DeviceCapabilities{}, hand};
  DeviceReading reading;
};

TEST_F(ClientDeviceTest, ReadsEverySampleOnce) {
  reading.t = 7.0;
  EXPECT_FALSE(device.read(0.0, reading));
  EXPECT_EQ(reading.t, 7.0) << "it is left alone";
  EXPECT_EQ(hand.put(at(1.0), 0.1), 1U);
  EXPECT_EQ(hand.seen(), 0U);
  ASSERT_TRUE(device.read(0.2, reading));
  EXPECT_EQ(reading.t, 0.1) << "when it came";
  EXPECT_EQ(reading.pose.position.x(), 1.0);
  EXPECT_EQ(reading.velocity.linear.norm(), 0.0) << "of one sample nothing is known";
  EXPECT_EQ(hand.seen(), 1U);
  EXPECT_FALSE(device.read(0.3, reading));
  EXPECT_EQ(hand.put(at(2.0), 0.4), 2U);
  EXPECT_EQ(hand.put(at(3.0), 0.5), 3U);
  ASSERT_TRUE(device.read(0.6, reading)) << "the newest, and no other";
  EXPECT_EQ(reading.pose.position.x(), 3.0);
  EXPECT_EQ(hand.seen(), 3U);
  EXPECT_FALSE(device.read(0.7, reading));
}

TEST_F(ClientDeviceTest, VelocityIsThatOfASteadyMotion) {
  const Vector3d v(0.1, -0.2, 0.05), w(0, 0.5, 1.0);
  for (int k = 0; k <= 100; ++k) {
    const double t = 1e-3 * k;
    hand.put({v * t, rotation_by(w * t)}, t);
    ASSERT_TRUE(device.read(t, reading));
    if (k == 5) {  // one filter time
      EXPECT_NEAR(reading.velocity.linear.norm(), (1.0 - std::exp(-1.0)) * v.norm(), 1e-9);
    }
  }
  EXPECT_LE((reading.velocity.linear - v).norm(), 1e-6);
  EXPECT_LE((reading.velocity.angular - w).norm(), 1e-6);
}

TEST_F(ClientDeviceTest, VelocityDoesNotTrembleWithTheTimesOfArrival) {
  // 1 kHz, every other one 0.3 ms late: what two poses tell is up to 43 % too much.
  double worst = 0.0;
  for (int k = 0; k <= 200; ++k) {
    const double sent = 1e-3 * k, came = sent + (k % 2 == 0 ? 3e-4 : 0.0);
    hand.put(at(0.1 * sent), came);
    ASSERT_TRUE(device.read(came, reading));
    if (k > 50) worst = std::max(worst, std::abs(reading.velocity.linear.x() - 0.1));
  }
  EXPECT_LE(worst, 0.04 * 0.1);
}

TEST_F(ClientDeviceTest, SamplesOfOneInstantHaveNoInfiniteVelocity) {
  hand.put(at(0.0), 1.0);
  device.read(1.0, reading);
  hand.put(at(1.0), 1.0);
  ASSERT_TRUE(device.read(1.0, reading));
  EXPECT_EQ(reading.velocity.linear.norm(), 0.0);
  EXPECT_EQ(reading.pose.position.x(), 1.0);
}

TEST_F(ClientDeviceTest, IsHeldFromTheFirstPoseUntilItIsLetGo) {
  EXPECT_FALSE(hand.is_held());
  hand.put(at(0.0), 0.0);
  EXPECT_TRUE(hand.is_held());
  hand.let_go();
  EXPECT_FALSE(hand.is_held());
  EXPECT_TRUE(device.read(0.0, reading)) << "its last pose is there all the same";
  hand.put(at(0.0), 0.0);
  EXPECT_TRUE(hand.is_held());
}

TEST_F(ClientDeviceTest, WaitsUntilTheBeatWithoutAPose) {
  const LoopClock clock;
  clock.sleep_until(0.5);  // so that until and for how long are not the same
  double late = 60.0;
  for (int k = 0; k < 3; ++k) {
    const double until = clock.now() + 0.02;
    device.wait(clock, until);
    EXPECT_GE(clock.now(), until - 1e-4);  // a wait in the kernel's nanoseconds
    late = std::min(late, clock.now() - until);
  }
  EXPECT_LT(late, 0.4);
}

TEST_F(ClientDeviceTest, ABeatThatIsOverIsNotWaitedFor) {
  const LoopClock clock;
  for (const double until : {-1.0, 0.0}) {
    const double begin = clock.now();
    device.wait(clock, until);
    EXPECT_LE(clock.now() - begin, 5.0);
  }
}

TEST_F(ClientDeviceTest, APoseEndsTheWait) {
  const LoopClock clock;
  std::atomic<bool> waiting = false;
  std::thread client([&] {
    while (!waiting) std::this_thread::yield();
    clock.sleep_until(clock.now() + 0.02);
    hand.put(at(0.5), clock.now());
  });
  const double begin = clock.now();
  waiting = true;
  device.wait(clock, begin + 60.0);
  EXPECT_LE(clock.now() - begin, 30.0);
  client.join();
  ASSERT_TRUE(device.read(clock.now(), reading));
  EXPECT_EQ(reading.pose.position.x(), 0.5);
}

TEST_F(ClientDeviceTest, APoseThatCameBeforeCounts) {
  const LoopClock clock;
  hand.put(at(0.5), clock.now());
  const double begin = clock.now();
  device.wait(clock, begin + 60.0);
  EXPECT_LE(clock.now() - begin, 30.0);
}

// However fast a client sends, the loop has time of its own between two ticks.
TEST_F(ClientDeviceTest, TicksAreApart) {
  const LoopClock clock;
  std::atomic<bool> ends = false;
  std::thread client([&] {
    while (!ends) hand.put(at(0.0), clock.now());
  });
  const double begin = clock.now();
  constexpr int kTicks = 200;
  for (int k = 0; k <= kTicks; ++k) device.wait(clock, clock.now() + 60.0);
  EXPECT_GE(clock.now() - begin, kTicks * ClientDevice::kLeastPeriod);
  ends = true;
  client.join();
}

TEST(ClientHand, GoesFromThreadToThread) {
  ClientHand hand;
  constexpr std::uint64_t kSamples = 100'000;
  std::thread client([&] {
    for (std::uint64_t k = 1; k <= kSamples; ++k) {
      const auto x = static_cast<double>(k);
      hand.put({{x, 2 * x, 3 * x}, Quaterniond::Identity()}, x);
    }
  });
  std::uint64_t last = 0, wrong = 0;
  while (last < kSamples) {
    const ClientHand::Sample& sample = hand.newest();
    const auto x = static_cast<double>(sample.number);
    wrong +=
        sample.number < last || sample.t != x || sample.pose.position != Vector3d(x, 2 * x, 3 * x) ? 1 : 0;
    last = sample.number;
    std::this_thread::yield();
  }
  client.join();
  EXPECT_EQ(wrong, 0U);
  EXPECT_EQ(hand.seen(), kSamples);
}

/// Whether it is, without waiting.
bool is_set(const Wake& wake) {
  pollfd watched{wake.descriptor(), POLLIN, 0};
  return ::poll(&watched, 1, 0) == 1;
}

TEST(Wake, IsSetUntilItIsTakenBack) {
  Wake wake;
  EXPECT_FALSE(is_set(wake));
  wake.set();
  wake.set();
  EXPECT_TRUE(is_set(wake));
  const double begin = monotonic_now();
  wake.wait(60.0);
  EXPECT_LE(monotonic_now() - begin, 30.0);
  EXPECT_FALSE(is_set(wake)) << "both were taken back";
  wake.set();
  wake.clear();
  EXPECT_FALSE(is_set(wake));
  wake.clear();  // does not block
  wake.wait(0.0);
  wake.wait(-1.0);
}

TEST(Wake, WaitsAsLongAsItIsTold) {
  Wake wake;
  for (const double seconds : {0.0, 1e-3, 0.02}) {
    const double begin = monotonic_now();
    wake.wait(seconds);
    EXPECT_GE(monotonic_now() - begin, seconds - 1e-6);
  }
}

TEST(TickFeed, WakesForEveryTickWhileAClientHoldsTheHand) {
  ClientHand hand;
  TickFeed feed(hand);
  const auto is_woken = [&] {
    const bool set = is_set(feed.wake());
    feed.wake().clear();
    return set;
  };
  EXPECT_FALSE(feed.update());
  TickRecord record;
  record.t = 1.0;
  feed.see(record, {});
  ASSERT_TRUE(feed.update());
  EXPECT_FALSE(feed.update());
  EXPECT_EQ(feed.newest().record.t, 1.0);
  EXPECT_EQ(feed.newest().answers, 0U);
  EXPECT_FALSE(is_woken());
  hand.put(at(0.0), 0.0);
  feed.see(record, {});
  ASSERT_TRUE(feed.update());
  EXPECT_EQ(feed.newest().answers, 0U) << "the servo thread has not seen it yet";
  hand.newest();
  for (int k = 0; k < 3; ++k) {  // of which only the first has another pose
    is_woken();
    feed.see(record, {});
    EXPECT_TRUE(is_woken());
    ASSERT_TRUE(feed.update());
    EXPECT_EQ(feed.newest().answers, 1U);
  }
  hand.let_go();
  feed.see(record, {});
  EXPECT_FALSE(is_woken());
}

}  // namespace
}  // namespace palpate

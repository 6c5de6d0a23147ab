// A device whose driver speaks CRTK, over a network that does what networks do.
#include <palpate/gateway/crtk_device.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/gateway/crtk_options.h>
#include <palpate/servo/servo_tick.h>
#include <support/crtk_link.h>

namespace palpate::test {
namespace {

using testing::HasSubstr;

TEST(CrtkDevice, AWrenchGoesOutAlongBothFramesWithTheStampThatItAnswers) {
  CrtkLink link;
  Pose turned;
  turned.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  link.pose(turned, 77.25);
  ASSERT_TRUE(link.tick());
  const auto before = link.peer->sent();
  link.device->write({{1, 0, 0}, {0, 0, 0.5}});
  for (int k = 0; k < 200 && link.peer->sent() == before; ++k) sleep_until(monotonic_now() + kMilli);
  const CrtkWrench sent = link.peer->last();
  EXPECT_TRUE(sent.spatial.force.isApprox(Eigen::Vector3d(1, 0, 0)));
  EXPECT_TRUE(sent.body.force.isApprox(Eigen::Vector3d(0, -1, 0), 1e-12));
  EXPECT_TRUE(sent.body.torque.isApprox(Eigen::Vector3d(0, 0, 0.5), 1e-12));
  EXPECT_EQ(sent.stamp, 77.25);
}

TickRecord pressed_tick() {
  TickRecord tick;
  tick.map.offset = {0, 0, 1};
  tick.map.rotation = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX());
  tick.reading.pose.position = {0.1, 0.2, 0.3};
  tick.force_scale = 0.5;
  tick.felt.local.count = 1;
  tick.felt.local.planes[0] = {{0, 0, 1.5}, Eigen::Vector3d::UnitZ()};
  tick.felt.local.stiffness = 500.0;
  return tick;
}

TEST(CrtkDevice, TheSurfaceGoesInTheDevicesFrameToWhoWantsItAndHasNoShareOnceItIsStopped) {
  CrtkLink link;
  link.pose(Pose(), 77.25);
  ASSERT_TRUE(link.tick());
  link.device->write({});
  link.device->see(pressed_tick(), {});
  sleep_until(monotonic_now() + 0.05);
  EXPECT_TRUE(link.peer->models().empty()) << "nobody wants it";
  link.peer->wants = true;
  sleep_until(monotonic_now() + 0.3);
  link.device->see(pressed_tick(), {});
  for (int k = 0; k < 200 && link.peer->models().empty(); ++k) sleep_until(monotonic_now() + kMilli);
  ASSERT_FALSE(link.peer->models().empty());
  const auto [model, stamp] = link.peer->models().back();
  EXPECT_EQ(stamp, 77.25);
  EXPECT_EQ(model.share, 0.5);
  EXPECT_EQ(model.position, Eigen::Vector3d(0.1, 0.2, 0.3));
  ASSERT_EQ(model.surface.count, 1U);
  EXPECT_TRUE(model.surface.planes[0].point.isApprox(Eigen::Vector3d(0, 0.5, 0)));
  EXPECT_TRUE(model.surface.planes[0].normal.isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_EQ(model.surface.stiffness, 500.0);
  EXPECT_THAT(numbers_of(model, stamp),
              testing::Pointwise(testing::DoubleNear(1e-12), {77.0, 250000000.0, 0.1, 0.2, 0.3, 500.0, 0.0,
                                                              0.0, 0.5, 0.0, 0.5, 0.0, 0.0, 1.0, 0.0}));
  link.device->close();
  EXPECT_EQ(link.peer->models().back().first.share, 0.0);
}

TEST(CrtkDevice, WhatComesOutOfOrderOrTwiceOrLateIsDroppedAndSaidOnce) {
  CrtkLink link;
  link.ticks(5, 0.0);
  const double stamp = driver_now();
  link.pose({{0.1, 0, 0}, Eigen::Quaterniond::Identity()}, stamp);
  link.pose({{0.2, 0, 0}, Eigen::Quaterniond::Identity()}, stamp);
  link.pose({{0.3, 0, 0}, Eigen::Quaterniond::Identity()}, stamp - 2e-3);
  link.pose({{0.4, 0, 0}, Eigen::Quaterniond::Identity()}, stamp - 0.5);
  ASSERT_TRUE(link.tick());
  EXPECT_EQ(link.reading.pose.position.x(), 0.1);
  EXPECT_EQ(link.device->dropped(), 3U);
  ASSERT_EQ(link.peer->said().size(), 1U);
  EXPECT_THAT(link.peer->said()[0], HasSubstr("late, repeated or out of order"));
}

TEST(CrtkDevice, AnAgeCountsTheJitterAndTheWayBack) {
  CrtkLink link;
  link.ticks(20, 0.0);
  for (int k = 0; k < 12; ++k) link.tick();  // nothing comes
  link.pose(0.01, 0.008);
  ASSERT_TRUE(link.tick());
  EXPECT_GT(link.clock.now() - link.reading.t, 0.008);
  link.ticks(5, 0.0);
  link.device->take_echo(link.peer->echo(), {driver_now(), "", "/arm"});
  link.pose(0.02);
  ASSERT_TRUE(link.tick());
  EXPECT_LE(link.reading.t, link.clock.now());
}

TEST(CrtkDevice, StampsOfTheFutureAreDroppedUntilTheClockIsKnownToBeSet) {
  CrtkLink link;
  link.ticks(5, 0.0);
  link.pose(0.1, -10.0);
  EXPECT_FALSE(link.tick());
  EXPECT_THAT(link.peer->said().at(0), HasSubstr("stamps in the future"));
  link.pose(0.2);
  EXPECT_TRUE(link.tick()) << "one of them changes nothing";
  for (int k = 0; k < 1200; ++k) {  // nor another, long after
    link.pose(0.2);
    link.tick();
  }
  link.pose(0.1, -10.0);
  EXPECT_FALSE(link.tick());
  link.pose(0.2);
  ASSERT_TRUE(link.tick());
  const std::uint32_t hand = link.reading.hand;
  bool read = false;
  for (int k = 0; k < 1300 && !read; ++k) {
    link.pose(0.3, -10.0);
    read = link.tick();
  }
  EXPECT_TRUE(read) << "it was set";
  EXPECT_NE(link.reading.hand, hand) << "and comes back through the gate";
}

TEST(CrtkDevice, InvalidStampsAreDroppedAndNeverReturned) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double stamp : {std::numeric_limits<double>::quiet_NaN(), infinity, -infinity, -1.0}) {
    CrtkLink link;
    link.pose(Pose(), stamp);
    EXPECT_FALSE(link.tick()) << "as the first";
    link.ticks(3, 0.0);
    link.pose(Pose(), stamp);
    link.pose(Pose(), stamp);
    EXPECT_FALSE(link.tick());
    EXPECT_EQ(link.device->dropped(), 3U);
    ASSERT_EQ(link.peer->said().size(), 1U);
    EXPECT_THAT(link.peer->said()[0], HasSubstr("have invalid stamps and are dropped"));
    link.pose(0.0);
    EXPECT_TRUE(link.tick());
  }
}

TEST(CrtkDevice, AnEchoWithAnInvalidStampIsNotUsed) {
  CrtkLink link;
  link.ticks(5, 0.0);
  for (int k = 0; k < 200 && link.peer->echo() == 0; ++k) sleep_until(monotonic_now() + kMilli);
  link.device->take_echo(link.peer->echo(), {std::numeric_limits<double>::quiet_NaN(), "", "/arm"});
  link.pose(0.1, 0.015);
  ASSERT_TRUE(link.tick());
  EXPECT_LT(link.reading.t, link.clock.now() - 0.01) << "its age is known";
}

// 28 h behind, as a clock that is not set, or ahead by an hour, as one of another time zone.
TEST(CrtkDevice, EchoesThatAnotherClockAnswersAreNamedAsTheReason) {
  for (const double ahead : {1e5, -4e3, 11.0, -11.0}) {
    CrtkLink link;
    link.ticks(3, 0.0);
    for (int k = 0; k < 200 && link.peer->echo() == 0; ++k) sleep_until(monotonic_now() + kMilli);
    link.device->take_echo(link.peer->echo(), {driver_now() + ahead, "", "/arm"});
    for (int k = 0; k < 100; ++k) {
      link.pose(0.1);
      ASSERT_FALSE(link.tick()) << ahead << ' ' << k;
    }
    EXPECT_EQ(link.device->status_text(), "poses are stamped by another clock than echoes");
    ASSERT_EQ(link.peer->said().size(), 1U) << ahead;
    EXPECT_THAT(link.peer->said()[0], HasSubstr("answer echoes with the clock of the poses"));
  }
}

TEST(CrtkDevice, AnotherFrameIsDropped) {
  CrtkLink link;
  link.ticks(3, 0.0);
  for (int k = 0; k < 100; ++k) {
    link.pose(0.5, 0.0, "world");
    EXPECT_FALSE(link.tick());
  }
  EXPECT_EQ(link.device->status(), DeviceStatus::kFault);
  EXPECT_EQ(link.device->status_text(), "poses have a wrong frame_id");
  ASSERT_EQ(link.peer->said().size(), 1U);
  EXPECT_THAT(link.peer->said()[0], HasSubstr("in the frame 'world', not 'base'"));
  const std::uint32_t hand = link.reading.hand;
  link.pose(0.0);
  EXPECT_TRUE(link.tick());
  EXPECT_EQ(link.device->status(), DeviceStatus::kEnabled);
  EXPECT_NE(link.reading.hand, hand);
}

TEST(CrtkDevice, ThePoseThatIsAcceptedFirstSetsTheFrame) {
  CrtkLink link;
  link.pose(std::numeric_limits<double>::quiet_NaN(), 0.0, "world");
  EXPECT_FALSE(link.tick());
  link.pose(0.1, 0.0, "base");
  EXPECT_TRUE(link.tick());
  link.pose(0.1, 0.0, "world");
  EXPECT_FALSE(link.tick());
}

TEST(CrtkDevice, APoseThatIsDroppedDoesNotSetTheFrameOfWrenches) {
  CrtkLink link;
  const auto frame = [&] {
    const std::uint64_t before = link.peer->sent();
    link.device->write({});
    for (int k = 0; k < 5000 && link.peer->sent() == before; ++k) sleep_until(monotonic_now() + kMilli);
    return link.peer->frame();
  };
  EXPECT_EQ(frame(), "");
  link.pose(std::numeric_limits<double>::quiet_NaN(), 0.0, "world");
  EXPECT_EQ(frame(), "");
  link.pose(0.1, 0.0, "base");
  EXPECT_EQ(frame(), "base");
  link.pose(0.1, 0.0, "world");
  link.pose(0.1, 0.0, "camera", "/other");
  EXPECT_EQ(frame(), "base");
  EXPECT_EQ(link.device->dropped(), 3U);
}

TEST(CrtkDevice, ASecondPublisherWaitsForTheFirstToBeSilent) {
  CrtkLink link;
  link.ticks(3, 0.1);
  const std::uint32_t hand = link.reading.hand;
  link.pose(0.9, 0.0, "base", "/other");
  EXPECT_FALSE(link.tick());
  ASSERT_EQ(link.peer->said().size(), 1U);
  EXPECT_THAT(link.peer->said()[0], HasSubstr("'/other' are dropped: '/arm' controls the device"));
  bool read = false;
  double since = monotonic_now();
  while (!read && monotonic_now() - since < 3.0) {
    link.pose(0.9, 0.0, "base", "/other");
    read = link.tick();
  }
  EXPECT_GT(monotonic_now() - since, 0.9);
  EXPECT_TRUE(read);
  EXPECT_NE(link.reading.hand, hand);
}

// A stray pose, as of `ros2 topic pub --once`, does not decide for the driver.
TEST(CrtkDevice, ANewPublisherMayHaveAnotherFrame) {
  CrtkLink link;
  link.pose(0.1, 0.0, "", "/stray");
  ASSERT_TRUE(link.tick());
  link.pose(0.2, 0.0, "base", "/driver");
  EXPECT_FALSE(link.tick()) << "not while the first may go on";
  const std::uint32_t hand = link.reading.hand;
  sleep_until(monotonic_now() + 1.05 * CrtkDevice::kSilence);
  link.pose(std::numeric_limits<double>::quiet_NaN(), 0.0, "world", "/driver");
  link.pose(0.2, 0.0, "base", "/driver");
  ASSERT_TRUE(link.tick());
  EXPECT_NE(link.reading.hand, hand) << "through the gate";
  EXPECT_EQ(link.reading.pose.position.x(), 0.2);
  const std::uint64_t before = link.peer->sent();
  link.device->write({});
  for (int k = 0; k < 5000 && link.peer->sent() == before; ++k) sleep_until(monotonic_now() + kMilli);
  EXPECT_EQ(link.peer->frame(), "base");
  for (const char* other : {"", "world"}) {
    link.pose(0.3, 0.0, other, "/driver");
    EXPECT_FALSE(link.tick()) << "the frame is set again";
  }
  EXPECT_THAT(link.peer->said().back(), HasSubstr("in the frame '', not 'base'"));
}

TEST(CrtkDevice, NoPublisherHasAnotherFrameThanTheOneThatIsGiven) {
  CrtkOptions o = crtk_options();
  o.frame = "base";
  CrtkLink link(o);
  link.ticks(3, 0.1);
  sleep_until(monotonic_now() + 1.05 * CrtkDevice::kSilence);
  link.pose(0.2, 0.0, "world", "/other");
  EXPECT_FALSE(link.tick());
  link.pose(0.2, 0.0, "base", "/other");
  EXPECT_TRUE(link.tick());
  EXPECT_THAT(link.peer->said().at(0), HasSubstr("or the option frame"));
}

// A line, and no force, until it has ended; then through the gate.
TEST(CrtkDevice, AnotherPublisherOfWrenchesEndsTheForce) {
  CrtkLink link;
  link.ticks(3, 0.1);
  const std::uint32_t hand = link.reading.hand;
  link.device->set_other_writer("/teleoperation");
  for (int k = 0; k < 100; ++k) {
    link.pose(0.1);
    EXPECT_FALSE(link.tick());
  }
  EXPECT_EQ(link.device->status(), DeviceStatus::kFault);
  EXPECT_EQ(link.device->status_text(), "another program publishes wrenches for the device");
  ASSERT_EQ(link.peer->said().size(), 1U);
  EXPECT_THAT(link.peer->said()[0], HasSubstr("'/teleoperation' publishes wrenches for the device, too"));
  link.device->set_other_writer("");
  link.pose(0.1);
  EXPECT_TRUE(link.tick());
  EXPECT_NE(link.reading.hand, hand);
  EXPECT_EQ(link.device->status(), DeviceStatus::kEnabled);
}

// A recording that is played stamps its poses with the time at which they were recorded.
TEST(CrtkDevice, ANewPublisherMayHaveAnotherClock) {
  CrtkLink link;
  link.ticks(3, 0.1);
  sleep_until(monotonic_now() + 1.05 * CrtkDevice::kSilence);
  link.pose(0.9, 1000.0, "base", "/player");
  EXPECT_TRUE(link.tick());
  link.pose(0.8, 1000.0, "base", "/player");
  EXPECT_TRUE(link.tick());
  EXPECT_EQ(link.device->dropped(), 0U);
}

// They reach a terminal: neither an escape sequence nor a second line, nor a frame_id of a megabyte.
TEST(CrtkDevice, NamesOfTheNetworkAreSaidAsOnePrintableLine) {
  const auto expect_line = [](const std::string& line, const char* words) {
    EXPECT_TRUE(std::none_of(line.begin(), line.end(), [](char c) { return c >= 0 && c < ' '; })) << line;
    EXPECT_THAT(line, HasSubstr(words));
    EXPECT_LT(line.size(), 500U);
  };
  const std::string hostile = "\x1b[2J\nno force", endless(1'000'000, 'x');
  const std::string source = "/arm" + hostile, frame = "base" + hostile;
  CrtkLink link;
  const auto pose = [&](const std::string& in, const std::string& from, double age = 0.0) {
    link.pose(Pose(), driver_now() - age, in.c_str(), from.c_str());
  };
  pose(frame, source);
  pose("world" + hostile, source);
  pose(frame, "/other" + hostile);
  link.device->set_other_writer("/teleoperation" + hostile);
  pose(frame, source);
  link.device->set_other_writer("");
  for (const double since = monotonic_now(); monotonic_now() - since < 1.1 * StampClock::kSettle;) {
    pose(frame, source, 1000.0);
    sleep_until(monotonic_now() + kMilli);
  }
  pose(endless, source);
  ASSERT_EQ(link.peer->said().size(), 6U);
  expect_line(link.peer->said()[0], "in the frame 'world?[2J?no force', not 'base?[2J?no force'");
  expect_line(link.peer->said()[1],
              "poses of '/other?[2J?no force' are dropped: '/arm?[2J?no force' controls");
  expect_line(link.peer->said()[2], "'/teleoperation?[2J?no force' publishes wrenches");
  expect_line(link.peer->said()[3], "late, repeated or out of order");
  expect_line(link.peer->said()[4], "the clock of '/arm?[2J?no force' was set");
  expect_line(link.peer->said()[5], "set the driver's frame_id");
}

// What keeps the age limit, and so the time of a dead driver, short: 0.15 s and the fall.
TEST(CrtkDevice, OfTheLeastRateIsAFaultSoonAfterItsDriverHasDied) {
  CrtkOptions o = crtk_options();
  o.capabilities.rate = parse_crtk_arguments("ros1", "/omni,rate=20").options.capabilities.rate;
  CrtkLink link(o);
  link.ticks(5, 0.0);
  const double since = link.clock.now();
  while (link.device->status() == DeviceStatus::kEnabled && link.clock.now() - since < 3.0) link.tick();
  EXPECT_EQ(link.device->status_text(), "no poses received");
  EXPECT_GT(link.clock.now() - since, 0.15);
  EXPECT_LT(link.clock.now() - since, 1.0) << "far more than it takes, on a busy machine";
}

TEST(CrtkDevice, NanAndQuaternionsOfAnotherNormEndTheForce) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Pose> bad{{{nan, 0, 0}, Eigen::Quaterniond::Identity()},
                              {{1e9, 0, 0}, Eigen::Quaterniond::Identity()},
                              {{0, 0, 0}, Eigen::Quaterniond(0, 0, 0, 0)},
                              {{0, 0, 0}, Eigen::Quaterniond(2, 0, 0, 0)},
                              {{0, 0, 0}, Eigen::Quaterniond(nan, 0, 0, 0)}};
  for (const Pose& pose : bad) {
    CrtkLink link;
    link.ticks(3, 0.0);
    const std::uint32_t hand = link.reading.hand;
    link.pose(pose, driver_now());
    link.pose(pose, driver_now());
    EXPECT_FALSE(link.tick());
    ASSERT_EQ(link.peer->said().size(), 1U);
    EXPECT_THAT(link.peer->said()[0], HasSubstr("no force until valid poses arrive"));
    link.pose(0.0);
    ASSERT_TRUE(link.tick());
    EXPECT_NE(link.reading.hand, hand);
  }
}

/// A spring to the origin through a ServoTick, so that the governor is in it.
class Spring final : public ForceModel {
 public:
  bool wants_contacts() const override { return false; }
  ForceOutput evaluate(const ForceInput& input) override {
    ForceOutput out;
    out.wrench.force = -100.0 * input.tool.position;
    out.proxy = input.tool;
    return out;
  }
  void reset() override {}
};

TEST(CrtkDevice, LossThatIsShortIsNotFeltAndASilenceRampsToZeroAndComesBack) {
  CrtkLink link;
  Spring spring;
  ToolTracker* none = nullptr;
  ServoTick tick(*link.device, {&spring, none, nullptr});
  double at = 0.0;
  const auto force = [&](bool comes, double x) {
    constexpr double kStep = 1e-4;  // 0.1 m/s
    at += std::clamp(x - at, -kStep, kStep);
    if (comes) link.pose(at);
    link.clock.sleep_until(link.clock.now() + kMilli);
    return tick.run(link.clock.now()).sent.force.norm();
  };
  // More than once, since a machine that stands still for a while is a fault, too.
  const auto leans = [&](int every) {
    for (int round = 0; round < 10; ++round) {
      for (int k = 0; k < 800; ++k) force(true, 0.0);  // the gate
      for (int k = 0; k < 1000; ++k)
        if (force(k % every != 0, 0.02) > 1.9) return true;
    }
    return false;
  };
  EXPECT_TRUE(leans(1000));
  EXPECT_TRUE(leans(10)) << "a tenth of the poses is lost";
  double last = 0.0;
  for (int k = 0; k < 200; ++k) {
    last = force(false, 0.02);
    EXPECT_LE(last, 2.05);
  }
  EXPECT_EQ(last, 0.0);
  EXPECT_EQ(link.device->status(), DeviceStatus::kFault);
  EXPECT_EQ(link.device->status_text(), "no poses received");
  for (int k = 0; k < 100; ++k) EXPECT_EQ(force(true, 0.02), 0.0) << "the gate";
  EXPECT_TRUE(leans(1000));
}

// However long it has been open.
TEST(CrtkDevice, ATickWithoutAPoseIsNoFault) {
  CrtkLink link;
  bool stays = false;
  for (int round = 0; round < 10 && !stays; ++round) {  // since a machine that stands still is one
    link.ticks(100, 0.0);
    EXPECT_FALSE(link.tick());
    stays = link.device->status() == DeviceStatus::kEnabled;
  }
  EXPECT_TRUE(stays);
}

/// The force along x that is sent for a wrench.
double shown(const CrtkLink& link, double force) {
  const std::uint64_t before = link.peer->sent();
  link.device->write({{force, 0, 0}, {0, 0, 0}});
  for (int k = 0; k < 5000 && link.peer->sent() == before; ++k) sleep_until(monotonic_now() + kMilli);
  return link.peer->last().spatial.force.x();
}

// The force that was asked for meanwhile does not come all at once.
TEST(CrtkDevice, ShowsNothingAfterAFaultUntilNothingIsAskedFor) {
  CrtkLink link;
  const auto comes = [&] {
    bool read = false;
    for (int k = 0; k < 1000 && !read; ++k) {
      link.pose(0.0);
      read = link.tick();
    }
    return read && link.device->status() == DeviceStatus::kEnabled;
  };
  ASSERT_TRUE(comes());
  EXPECT_EQ(shown(link, 1.0), 1.0);
  for (int k = 0; k < 2000 && link.device->status() != DeviceStatus::kFault; ++k) link.tick();
  ASSERT_EQ(link.device->status(), DeviceStatus::kFault);
  EXPECT_EQ(shown(link, 1.0), 0.0);
  ASSERT_TRUE(comes());
  EXPECT_EQ(shown(link, 1.0), 0.0) << "it has come back";
  EXPECT_EQ(shown(link, 0.0), 0.0);
  EXPECT_EQ(shown(link, 1.0), 1.0);
}

/// While poses arrive.
void listens(CrtkLink& link, bool whether) {
  link.peer->listens = whether;
  if (whether) ++link.peer->came;
  for (int k = 0; k < 5000 && link.device->has_listener() != whether; ++k) link.ticks(1, 0.0);
  ASSERT_EQ(link.device->has_listener(), whether);
}

// Whoever subscribes in contact gets no step.
TEST(CrtkDevice, ShowsNothingToNobodyAndAListenerThatComesNothingUntilNothingIsAskedFor) {
  CrtkLink link;
  link.ticks(3, 0.0);
  EXPECT_EQ(shown(link, 1.0), 1.0);
  const std::uint32_t hand = link.reading.hand;
  listens(link, false);
  for (const double force : {1.0, 0.0, 1.0}) EXPECT_EQ(shown(link, force), 0.0) << "nobody listens";
  link.pose(0.0);
  EXPECT_TRUE(link.tick()) << "poses are used all the same";
  listens(link, true);
  EXPECT_EQ(shown(link, 1.0), 0.0);
  EXPECT_EQ(shown(link, 0.0), 0.0);
  EXPECT_EQ(shown(link, 1.0), 1.0);
  link.pose(0.0);
  ASSERT_TRUE(link.tick());
  EXPECT_NE(link.reading.hand, hand) << "the governor's gate closes";
}

// A recorder may listen already, so that the first wrench to a driver is not that of the first listener.
TEST(CrtkDevice, ShowsNothingOnceAnotherListenerComesUntilNothingIsAskedFor) {
  CrtkLink link;
  link.ticks(3, 0.0);
  EXPECT_EQ(shown(link, 1.0), 1.0);
  const std::uint32_t hand = link.reading.hand;
  ++link.peer->came;
  EXPECT_EQ(shown(link, 1.0), 0.0) << "at once, also what the loop wrote before it heard of it";
  EXPECT_EQ(shown(link, 1.0), 0.0);
  link.pose(0.0);
  ASSERT_TRUE(link.tick());
  EXPECT_NE(link.reading.hand, hand) << "the governor's gate closes";
  EXPECT_EQ(shown(link, 0.0), 0.0);
  EXPECT_EQ(shown(link, 1.0), 1.0);
}

TEST(CrtkDevice, ShowsNoSurfaceToAListenerThatComesUntilNothingIsAskedFor) {
  CrtkLink link;
  link.peer->wants = true;
  TickRecord record;
  record.force_scale = 1.0;
  const auto share = [&] {
    const std::size_t before = link.peer->models().size();
    link.ticks(1, 0.0);
    link.device->write({{1.0, 0, 0}, {0, 0, 0}});
    link.device->see(record, {});
    for (int k = 0; k < 200 && link.peer->models().size() == before; ++k)
      sleep_until(monotonic_now() + kMilli);
    return link.peer->models().empty() ? -1.0 : link.peer->models().back().first.share;
  };
  for (int k = 0; k < 100 && !(share() > 0.0);) ++k;
  ASSERT_GT(share(), 0.0);
  ++link.peer->came;
  EXPECT_EQ(share(), 0.0);
  EXPECT_EQ(share(), 0.0);
  EXPECT_EQ(shown(link, 0.0), 0.0);
  EXPECT_GT(share(), 0.0);
}

TEST(CrtkDevice, WhoTakesOnlyTheLocalModelListensToo) {
  CrtkLink link;
  listens(link, false);
  link.peer->wants = true;
  for (int k = 0; k < 5000 && !link.device->has_listener(); ++k) link.tick();
  EXPECT_TRUE(link.device->has_listener());
}

TEST(CrtkDevice, SaysThatNothingSubscribesToItsWrenchesWhilePosesArrive) {
  CrtkLink link;
  listens(link, false);
  const auto waits = [&](double seconds, bool poses) {
    for (const double since = monotonic_now(); monotonic_now() - since < seconds;) {
      if (poses) link.pose(0.0);
      link.tick();
    }
    return link.peer->said().size();
  };
  EXPECT_EQ(waits(1.2 * CrtkDevice::kDiscovery, false), 0U) << "there is no driver";
  const double since = monotonic_now();
  while (link.peer->said().empty() && monotonic_now() - since < 10.0) {
    link.pose(0.0);
    link.tick();
  }
  EXPECT_GT(monotonic_now() - since, 0.9 * CrtkDevice::kDiscovery);
  ASSERT_EQ(waits(0.5, true), 1U);
  EXPECT_THAT(link.peer->said()[0], HasSubstr("nothing subscribes to spatial/servo_cf or body/servo_cf"));
}

TEST(CrtkDevice, IsCarriedOnNoFartherThanItsBound) {
  CrtkOptions o = crtk_options();
  o.extrapolation = 5e-3;
  CrtkLink link(o);
  EXPECT_GE(link.device->capabilities().delay, 5e-3) << "it looks newer than it is by that";
  Twist twist;
  twist.linear.x() = 0.2;
  for (int k = 0; k < 20; ++k) {
    link.device->take_velocity({0.0, "base", "/arm"}, twist);
    link.pose(2e-4 * k);
    ASSERT_TRUE(link.tick());
  }
  const double x = link.reading.pose.position.x();
  double last = link.reading.t;
  for (int k = 0; k < 20; ++k) {
    if (!link.tick()) continue;
    ASSERT_GT(link.reading.t, last);
    last = link.reading.t;
  }
  EXPECT_GT(link.reading.pose.position.x(), x + 1e-4);
  EXPECT_LE(link.reading.pose.position.x(), x + 5e-3 * 0.2 + 1e-9);
  o.extrapolation = 0.5;
  EXPECT_THROW(CrtkDevice(o, std::make_unique<CrtkPeer>()), Error);
}

// Poses stand still while the driver says 0.2 m/s and 3 rad/s: where both are heard, it is the driver's that
// counts.
TEST(CrtkDevice, IsCarriedOnByTheVelocityThatItsDriverTells) {
  CrtkOptions o = crtk_options();
  o.extrapolation = 5e-3;
  CrtkLink link(o);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Twist told{{0.2, 0, 0}, {0, 0, 3}};
  const auto carried = [&](const char* source, const Twist& twist, double seconds_ago) {
    link.ticks(5, 0.0);
    link.device->take_velocity({0.0, "base", source}, twist);
    sleep_until(monotonic_now() + seconds_ago);
    link.pose(0.0);
    EXPECT_TRUE(link.tick());
    DeviceReading next = link.reading;
    for (int k = 0; k < 4; ++k) {
      if (link.tick()) next = link.reading;
    }
    return next.pose;
  };
  DevicePose moved;  // at once, unless the machine stands still meanwhile
  for (int round = 0; round < 10 && moved.position.isZero(); ++round) moved = carried("/arm", told, 0.0);
  EXPECT_GT(moved.position.x(), 1e-4);
  EXPECT_GT(2.0 * moved.orientation.z(), 1e-3);
  EXPECT_EQ(carried("/arm", told, 0.05).position.x(), 0.0) << "that one is old";
  EXPECT_EQ(carried("/other", told, 0.0).position.x(), 0.0);
  EXPECT_EQ(carried("/arm", {{nan, 0, 0}, {0, 0, 0}}, 0.0).position.x(), 0.0);
  EXPECT_EQ(carried("/arm", {{0.2, 0, 0}, {0, nan, 0}}, 0.0).position.x(), 0.0);
}

TEST(CrtkDevice, NothingIsCarriedOnBeforeTheFirstPoseAndNothingSentBeforeTheFirstTick) {
  CrtkOptions o = crtk_options();
  o.extrapolation = 5e-3;
  CrtkLink link(o);
  for (int k = 0; k < 200; ++k) EXPECT_FALSE(link.tick()) << "there is no pose";
  EXPECT_EQ(link.peer->sent(), 0U);
  EXPECT_GT(link.peer->echo(), 0U) << "though the sender runs";
}

TEST(CrtkDevice, AsksForAnEchoTenTimesASecondHoweverOftenItWrites) {
  CrtkLink link;
  link.ticks(5, 0.0);
  const std::uint64_t first = link.peer->echo();
  const double begin = monotonic_now();
  for (int k = 0; k < 400; ++k) {
    link.device->write({});
    sleep_until(monotonic_now() + kMilli);
  }
  EXPECT_GE(link.peer->echo(), first + 1);
  EXPECT_LE(link.peer->echo(), first + 10.0 * (monotonic_now() - begin) + 1.0);
}

TEST(CrtkDevice, TheOneWayDelayMayBeNoneAndNotTheAgeLimit) {
  CrtkOptions o = crtk_options();
  o.one_way = 0.0;
  EXPECT_NO_THROW(CrtkDevice(o, std::make_unique<CrtkPeer>()));
  for (const double wrong : {-1e-3, 0.02, std::numeric_limits<double>::quiet_NaN()}) {
    o.one_way = wrong;
    EXPECT_THROW(CrtkDevice(o, std::make_unique<CrtkPeer>()), Error) << wrong;
  }
}

TEST(CrtkDevice, APublisherWhoseClockWasSetBackIsTakenAfterASecondThroughTheGateAndSaid) {
  CrtkLink link;
  link.ticks(5, 0.0);
  const std::uint32_t hand = link.reading.hand;
  const double since = monotonic_now();
  bool read = false;
  while (!read && monotonic_now() - since < 3.0) {
    link.pose(0.3, 1000.0);
    read = link.tick();
  }
  EXPECT_TRUE(read);
  EXPECT_GT(monotonic_now() - since, 0.99 * StampClock::kSettle);
  EXPECT_NE(link.reading.hand, hand);
  ASSERT_EQ(link.peer->said().size(), 2U);
  EXPECT_THAT(link.peer->said()[0], HasSubstr("late, repeated or out of order"));
  EXPECT_THAT(link.peer->said()[1],
              HasSubstr("the clock of '/arm' was set; its latency is taken to be 0.5 ms"));
}

// Nothing comes for half a second, and then everything half a second late.
TEST(CrtkDevice, PosesThatComeLateStayDroppedHoweverLong) {
  CrtkLink link;
  link.ticks(20, 0.0);
  sleep_until(monotonic_now() + 0.6);
  for (int k = 0; k < 3000; ++k) {
    link.pose(0.1, 0.5);
    ASSERT_FALSE(link.tick()) << k;
  }
  EXPECT_EQ(link.device->status_text(), "poses are late or out of order");
  ASSERT_EQ(link.peer->said().size(), 1U);
  EXPECT_THAT(link.peer->said()[0],
              HasSubstr("shorten the latency or, if the driver's clock was set, restart"));
  link.pose(0.1);
  EXPECT_TRUE(link.tick()) << "the latency is short again";
}

// What was carried on looks newer than the pose that comes next, which was measured before.
TEST(CrtkDevice, NoReadingIsOlderThanTheOneBefore) {
  CrtkOptions o = crtk_options();
  o.extrapolation = 5e-3;
  CrtkLink link(o);
  int came = 0;
  for (int round = 1; round <= 30; ++round) {
    link.ticks(5, 0.0);
    if (!link.tick()) continue;  // carried on to now
    const double told = link.reading.t;
    link.pose(1e-3 * round, 4e-4);
    if (!link.device->read(link.clock.now(), link.reading)) continue;
    ASSERT_GT(link.reading.t, told);
    came += link.reading.pose.position.x() == 1e-3 * round ? 1 : 0;
  }
  EXPECT_GT(came, 10);
}

/// A network that cannot be reached.
class NoNetwork final : public CrtkTransport {
 public:
  void start(CrtkDevice&) override { throw Error("there is no network"); }
  void stop() noexcept override {}
  void send(const CrtkWrench&, const std::string&) override {}
  bool has_listener() override { return false; }
  std::uint64_t arrivals() override { return 0; }
  bool wants_local_model() override { return false; }
  void send_local_model(const LocalModel&, double) override {}
  void send_echo(std::uint64_t) override {}
  void say(const std::string&) override {}
};

TEST(CrtkDevice, IsOpenedByOneHandOfAProgramAtATime) {
  CrtkDevice first(crtk_options(), std::make_unique<CrtkPeer>());
  first.open();
  CrtkDevice second(crtk_options(), std::make_unique<CrtkPeer>());
  EXPECT_THROW(open_device(second, {}), Error);
  EXPECT_EQ(second.status(), DeviceStatus::kClosed);
  CrtkDevice third(crtk_options(), std::make_unique<CrtkPeer>());
  EXPECT_THROW(third.open(), Error) << "the one that was refused has not freed the name";
  CrtkOptions other = crtk_options();
  other.capabilities.name = "another";
  CrtkDevice fourth(other, std::make_unique<CrtkPeer>());
  EXPECT_NO_THROW(fourth.open());
  first.close();
  EXPECT_NO_THROW(second.open());
}

TEST(CrtkDevice, ThatCouldNotBeOpenedMayBeOpenedByAnother) {
  CrtkDevice none(crtk_options(), std::make_unique<NoNetwork>());
  EXPECT_THROW(none.open(), Error);
  CrtkDevice some(crtk_options(), std::make_unique<CrtkPeer>());
  EXPECT_NO_THROW(some.open());
}

TEST(CrtkDevice, MayBeOpenForLongBeforeTheLoopBegins) {
  auto made = std::make_unique<CrtkPeer>();
  CrtkDevice device(crtk_options(), std::move(made));
  open_device(device, {});
  for (int k = 0; k < 100; ++k) {
    device.take_pose({driver_now(), "base", "/arm"}, {});
    sleep_until(monotonic_now() + kMilli);
  }
  const LoopClock clock;
  sleep_until(monotonic_now() + 0.2);  // and the loop's clock, before the first tick
  device.enable();
  DeviceReading reading;
  int read = 0, fresh = 0;
  for (int k = 0; k < 50; ++k) {
    device.take_pose({driver_now(), "base", "/arm"}, {});
    clock.sleep_until(clock.now() + kMilli);
    const double t = clock.now();
    if (!device.read(t, reading)) continue;
    ++read;
    ASSERT_LE(reading.t, t);
    ASSERT_GT(reading.t, t - 0.5);
    fresh += reading.t > t - 0.1 ? 1 : 0;
  }
  EXPECT_GT(read, 40);
  EXPECT_GT(fresh, 30);
}

}  // namespace
}  // namespace palpate::test

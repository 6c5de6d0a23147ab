#include <palpate/gateway/live_topics.h>

#include <functional>
#include <map>
#include <memory>
#include <new>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <support/allocation_guard.h>
#include <support/splats.h>

namespace palpate {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kHand = "/palpate/client/measured_cp";
constexpr const char* kAnswer = "/palpate/client/servo_cf";
constexpr const char* kSpatial = "/palpate/spatial/servo_cf";
constexpr const char* kBody = "/palpate/body/servo_cf";
constexpr const char* kContacts = "/palpate/contacts";

/// A device that is turned by 90 degrees about z, half as large as the world, and elsewhere.
WorkspaceMap map() {
  WorkspaceMap result;
  result.scale = 2.0;
  result.rotation = Quaterniond(AngleAxisd(M_PI / 2, Vector3d::UnitZ()));
  result.offset = {1, 0, 0};
  return result;
}

class LiveTopicsTest : public testing::Test {
 protected:
  void begin(bool client_is_device = false) {
    live = std::make_unique<LiveTopics>(hub, feed, hand, clock, statistics, map(), client_is_device);
    for (auto* client : {&first, &second})
      *client = std::make_unique<Client>(
          hub, [] {}, [this] { return now; });
  }

  /// Everything that waits for a client, by topic; what is no publication under its op.
  static std::map<std::string, std::vector<Json>> all(Client& client) {
    std::map<std::string, std::vector<Json>> messages;
    while (const auto outgoing = client.next()) {
      const Json message = decode_json(*outgoing->bytes);
      messages[message.value("topic", message.value("op", ""))].push_back(message.value("msg", Json()));
    }
    return messages;
  }

  void subscribe(Client& client, const std::vector<std::string>& topics) {
    for (const std::string& topic : topics)
      client.receive(Json{{"op", "subscribe"}, {"topic", topic}, {"queue_length", 100}}.dump(), false);
    EXPECT_THAT(all(client), IsEmpty());
  }

  static void put(Client& client, const Vector3d& position, const std::string& frame, int seconds = 0) {
    const Json message{{"header", header({seconds, 0}, frame, 0)}, {"pose", to_json(Pose{position})}};
    client.receive(Json{{"op", "publish"}, {"topic", kHand}, {"msg", message}}.dump(), false);
    client.caught_up();
  }

  /// What the servo thread does.
  void tick() {
    hand.newest();
    ++statistics.ticks;
    feed.see(record, {});
  }

  static TickRecord quiet() {
    TickRecord record;
    record.map = map();
    record.tool.position = {0, 0, 5};
    return record;
  }

  double now = 0.0;
  Hub hub;
  ClientHand hand;
  TickFeed feed{hand};
  LoopClock clock;
  LoopStatistics statistics;
  TickRecord record = quiet();
  std::unique_ptr<LiveTopics> live;
  std::unique_ptr<Client> first, second;
};

TEST_F(LiveTopicsTest, TakesAPoseInTheWorldToTheDevice) {
  begin();
  EXPECT_FALSE(hand.is_held());
  put(*first, {1, 2, 4}, "world");
  EXPECT_THAT(all(*first), IsEmpty());
  EXPECT_TRUE(hand.is_held());
  EXPECT_TRUE(live->is_held());
  // (0, 2, 4) from the offset, turned back to (2, 0, 4), and half of that.
  EXPECT_TRUE(hand.newest().pose.position.isApprox(Vector3d(1, 0, 2)));
  EXPECT_NEAR(hand.newest().pose.orientation.angularDistance(map().rotation.conjugate()), 0.0, 1e-12);
  put(*first, {1, 2, 4}, "device");
  EXPECT_EQ(hand.newest().pose.position, Vector3d(1, 2, 4));
}

// The clutch has moved the device in the world: what a client says of the world is of that one.
TEST_F(LiveTopicsTest, TakesAPoseInTheWorldToWhereTheDeviceIsNow) {
  begin();
  put(*first, {1, 2, 4}, "world");
  record.map.offset = {1, 4, 0};
  record.map.tool = Quaterniond(AngleAxisd(0.5, Vector3d::UnitX()));
  tick();
  live->publish();
  put(*first, {1, 6, 4}, "world");
  EXPECT_TRUE(hand.newest().pose.position.isApprox(Vector3d(1, 0, 2)));
  EXPECT_LT(record.map.to_world(DevicePose(hand.newest().pose))
                .orientation.angularDistance(Quaterniond::Identity()),
            1e-12);
}

TEST_F(LiveTopicsTest, APoseWithoutAFrameIsInThatOfWhatTheClientIs) {
  begin(false);
  put(*first, {1, 2, 4}, "");
  EXPECT_TRUE(hand.newest().pose.position.isApprox(Vector3d(1, 0, 2))) << "whoever leads, in the world";
}

TEST_F(LiveTopicsTest, APoseWithoutAFrameIsTheDevicesOwnWhereThatIsTheClient) {
  begin(true);
  put(*first, {1, 2, 4}, "");
  EXPECT_EQ(hand.newest().pose.position, Vector3d(1, 2, 4));
}

TEST_F(LiveTopicsTest, OneClientHoldsTheToolUntilItGoes) {
  begin();
  put(*first, {1, 0, 0}, "device");
  put(*second, {2, 0, 0}, "device");
  const auto told = all(*second)["status"];
  ASSERT_EQ(told.size(), 1U);
  EXPECT_THAT(told[0].get<std::string>(), HasSubstr("another client holds the tool"));
  EXPECT_EQ(hand.newest().pose.position.x(), 1.0);
  second.reset();
  EXPECT_TRUE(hand.is_held()) << "that one did not hold it";
  first.reset();
  EXPECT_FALSE(hand.is_held());
  EXPECT_FALSE(live->is_held());
}

TEST_F(LiveTopicsTest, WhatIsNoPoseHoldsNothing) {
  begin();
  first->receive(Json{{"op", "publish"}, {"topic", kHand}, {"msg", Json::object()}}.dump(), false);
  EXPECT_EQ(all(*first)["status"].size(), 1U);
  EXPECT_FALSE(hand.is_held());
  put(*second, {2, 0, 0}, "device");
  EXPECT_TRUE(hand.is_held());
}

TEST_F(LiveTopicsTest, ASecondOfSilenceLetsGo) {
  begin();
  put(*first, {1, 0, 0}, "device");
  live->publish();
  EXPECT_TRUE(hand.is_held());
  clock.sleep_until(clock.now() + LiveTopics::kSilence + 0.01);
  live->publish();
  EXPECT_FALSE(hand.is_held());
  put(*second, {2, 0, 0}, "device");
  EXPECT_THAT(all(*second), IsEmpty());
  EXPECT_EQ(hand.newest().pose.position.x(), 2.0);
  live->publish();
  EXPECT_TRUE(hand.is_held()) << "a second counts from the newest pose on, not from the clock's first";
}

TEST_F(LiveTopicsTest, WhoHoldsItGetsTheForceOnceForEveryPoseThatWasFelt) {
  begin(true);
  for (Client* client : {first.get(), second.get()}) subscribe(*client, {kAnswer, kSpatial, kBody});
  put(*first, {1, 0, 0}, "device", 7);
  live->answer();
  EXPECT_THAT(all(*first)[kSpatial], IsEmpty()) << "it was not felt yet";

  record.sent = {{1, 2, 3}, {4, 5, 6}};
  record.sent_world = {{-2, 1, 3}, {-5, 4, 6}};  // turned by 90 degrees about z
  record.tool.orientation = Quaterniond(AngleAxisd(M_PI, Vector3d::UnitX()));
  tick();
  live->answer();
  auto told = all(*first);
  EXPECT_THAT(all(*second), IsEmpty());
  for (const char* topic : {kAnswer, kSpatial, kBody}) ASSERT_EQ(told[topic].size(), 1U) << topic;
  const Json answer = told[kAnswer][0], spatial = told[kSpatial][0], body = told[kBody][0];
  EXPECT_EQ(answer["wrench"], to_json(record.sent));
  EXPECT_EQ(answer["header"]["frame_id"], "device");
  EXPECT_EQ(answer["header"]["stamp"], (Json{{"secs", 7}, {"nsecs", 0}})) << "that of the pose";
  EXPECT_EQ(spatial["header"]["frame_id"], "world");
  EXPECT_EQ(spatial["wrench"], to_json(record.sent_world));
  EXPECT_EQ(body["header"]["frame_id"], "tool");
  EXPECT_NEAR(body["wrench"]["force"]["x"].get<double>(), -2.0, 1e-12);
  EXPECT_NEAR(body["wrench"]["force"]["y"].get<double>(), -1.0, 1e-12);
  EXPECT_NEAR(body["wrench"]["force"]["z"].get<double>(), -3.0, 1e-12);
  EXPECT_NEAR(body["wrench"]["torque"]["z"].get<double>(), -6.0, 1e-12);

  live->publish();
  EXPECT_THAT(all(*first), IsEmpty()) << "who gets it a tick does not get it 60 times a second, too";
  EXPECT_EQ(all(*second)[kSpatial].size(), 1U);
  live->publish();
  EXPECT_EQ(all(*first)[kSpatial].size(), 1U) << "but where none of its poses was felt since, it does";
}

TEST_F(LiveTopicsTest, TheFallToZeroReachesAClientThatHasFallenSilent) {
  begin(true);
  subscribe(*first, {kAnswer});
  put(*first, {1, 0, 0}, "device", 7);
  for (const double force : {3.0, 2.0, 0.0}) {
    record.sent = {{force, 0, 0}, {0, 0, 0}};
    tick();
    pollfd woken{feed.wake().descriptor(), POLLIN, 0};
    ASSERT_EQ(::poll(&woken, 1, 0), 1) << "the gateway is woken";
    live->answer();
    const std::vector<Json> told = all(*first)[kAnswer];
    ASSERT_EQ(told.size(), 1U);
    EXPECT_EQ(told[0]["wrench"]["force"]["x"], force);
    EXPECT_EQ(told[0]["header"]["stamp"]["secs"], 7) << "of the last pose";
  }
}

TEST_F(LiveTopicsTest, WhoHoldsItGetsTheSurfaceAboutTheToolInItsOwnFrame) {
  constexpr const char* kModel = "/palpate/client/local_model";
  begin(true);
  subscribe(*first, {kModel});
  subscribe(*second, {kModel});
  put(*first, {1, 0, 0}, "device", 7);
  record.reading.pose.position = {0.5, 0, 0};
  record.force_scale = 0.25;
  record.felt.local.stiffness = 300.0;
  record.felt.local.damping = 2.0;
  record.felt.local.friction = 0.5;
  record.felt.local.count = 1;
  record.felt.local.planes[0] = {{1, 0, 4}, {0, 1, 0}};
  tick();
  live->answer();
  EXPECT_THAT(all(*second), IsEmpty());
  const std::vector<Json> told = all(*first)[kModel];
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0]["header"]["frame_id"], "device");
  EXPECT_EQ(told[0]["header"]["stamp"]["secs"], 7) << "of the pose";
  EXPECT_EQ(told[0]["position"], to_json(Vector3d(0.5, 0, 0)));
  ASSERT_EQ(told[0]["planes"].size(), 1U);
  // Turned back by 90 degrees about z, half as far from the offset.
  EXPECT_NEAR(told[0]["planes"][0]["normal"]["x"].get<double>(), 1.0, 1e-12);
  EXPECT_NEAR(told[0]["planes"][0]["point"]["x"].get<double>(), 0.0, 1e-12);
  EXPECT_NEAR(told[0]["planes"][0]["point"]["z"].get<double>(), 2.0, 1e-12);
  EXPECT_EQ(told[0]["stiffness"], 300.0);
  EXPECT_EQ(told[0]["damping"], 2.0);
  EXPECT_EQ(told[0]["friction"], 0.5);
  EXPECT_EQ(told[0]["share"], 0.25);

  clock.sleep_until(clock.now() + LiveTopics::kSilence + 0.01);
  live->publish();
  EXPECT_EQ(all(*first)[kModel].back()["share"], 0.0) << "who loses the tool";
}

TEST_F(LiveTopicsTest, WhatADeviceShallShowGoesToNobodyElse) {
  begin(true);
  for (Client* client : {first.get(), second.get()}) subscribe(*client, {kAnswer});
  put(*first, {1, 0, 0}, "device");
  put(*second, {2, 0, 0}, "device");
  EXPECT_EQ(all(*second)["status"].size(), 1U);
  record.sent = {{5, 0, 0}, {0, 0, 0}};
  for (int k = 0; k < 10; ++k) {
    tick();
    live->answer();
    live->publish();
  }
  EXPECT_THAT(all(*second), IsEmpty());
  EXPECT_EQ(all(*first)[kAnswer].size(), 10U);
}

// The force on a simulated device is not that where the hand of a client is.
TEST_F(LiveTopicsTest, NoWrenchOfAnotherDeviceGoesToTheMotorsOfAClient) {
  constexpr const char* kModel = "/palpate/client/local_model";
  begin(false);
  subscribe(*first, {kAnswer, kModel, kSpatial});
  subscribe(*second, {kSpatial});
  const auto hold = [&](Client& client) {
    put(client, {1, 0, 0}, "device", 7);
    std::map<std::string, std::vector<Json>> told;
    for (int k = 0; k < 3; ++k) {
      record.sent = record.sent_world = {{5, 0, 0}, {0, 0, 0}};
      record.force_scale = 1.0;
      tick();
      live->answer();
      for (auto& [topic, messages] : all(client))
        told[topic].insert(told[topic].end(), messages.begin(), messages.end());
    }
    live->let_go();
    for (const char* topic : {kAnswer, kModel}) {
      EXPECT_EQ(told.count(topic), 0U);
      EXPECT_EQ(all(client).count(topic), 0U) << "nor when it is let go";
    }
    EXPECT_FALSE(told[kSpatial].empty()) << "what there is to see stays";
    return told["status"];
  };
  for (int k = 0; k < 2; ++k) {
    const std::vector<Json> said = hold(*first);
    ASSERT_EQ(said.size(), 1U) << "once for each time that it takes the tool";
    EXPECT_THAT(said[0].get<std::string>(), HasSubstr("--device client"));
  }
  EXPECT_THAT(hold(*second), IsEmpty()) << "who has no motors";
}

TEST_F(LiveTopicsTest, WhoLosesTheToolIsToldToShowNothing) {
  begin(true);
  subscribe(*first, {kAnswer});
  put(*first, {1, 0, 0}, "device");
  clock.sleep_until(clock.now() + LiveTopics::kSilence + 0.01);
  live->publish();
  const std::vector<Json> told = all(*first)[kAnswer];
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0]["wrench"], to_json(Wrench{}));
}

TEST_F(LiveTopicsTest, IsLetGoOfAlsoWhereThereIsNoMemoryToTellSo) {
  begin(true);
  subscribe(*first, {kAnswer});
  subscribe(*second, {kAnswer});
  put(*first, {1, 0, 0}, "device");
  test::fail_allocations(1);
  EXPECT_THROW(live->let_go(), std::bad_alloc);
  EXPECT_FALSE(live->is_held());
  EXPECT_FALSE(hand.is_held());
  put(*first, {1, 0, 0}, "device");
  EXPECT_TRUE(live->is_held());
  test::fail_allocations(1);
  first.reset();
  test::fail_allocations(0);
  EXPECT_FALSE(live->is_held()) << "the client that has gone";
}

TEST_F(LiveTopicsTest, OfThePosesThatWaitTheNewestCounts) {
  begin(true);
  const auto receive = [&](double x) {
    const Json message{{"header", header({}, "device", 0)}, {"pose", to_json(Pose{{x, 0, 0}})}};
    first->receive(Json{{"op", "publish"}, {"topic", kHand}, {"msg", message}}.dump(), false);
  };
  for (const double x : {1.0, 2.0, 3.0}) {
    receive(x);
    EXPECT_EQ(hand.newest().number, 0U) << "more of it waits";
  }
  first->caught_up();
  EXPECT_EQ(hand.newest().number, 1U);
  EXPECT_EQ(hand.newest().pose.position.x(), 3.0);
  second->caught_up();
  first->caught_up();
  EXPECT_EQ(hand.newest().number, 1U);
}

TEST_F(LiveTopicsTest, AnotherHandIsFeltOnceTheForceOfTheOneBeforeHasFallen) {
  begin(true);
  int changes = 0;
  live->on_other_hand = [&] { ++changes; };
  subscribe(*second, {kAnswer});
  put(*first, {1, 0, 0}, "device");
  const auto old_hand = hand.newest().hand;
  EXPECT_EQ(changes, 0) << "there was no hand before it";
  record.t = clock.now();
  record.state = GovernorState::kActive;
  record.sent = {{5, 0, 0}, {0, 0, 0}};
  tick();
  live->answer();
  first.reset();
  put(*second, {2, 0, 0}, "device");
  EXPECT_EQ(changes, 1);
  const auto next = [&](GovernorState state, double force) {
    record.t = clock.now();
    record.state = state;
    record.sent.force.x() = force;
    tick();
    live->answer();
  };
  next(GovernorState::kFalling, 3.0);
  put(*second, {2.5, 0, 0}, "device");
  next(GovernorState::kFalling, 0.0);
  EXPECT_EQ(hand.newest().pose.position.x(), 1.0);
  const std::vector<Json> wrenches = all(*second)[kAnswer];
  for (const Json& told : wrenches) EXPECT_EQ(told["wrench"], to_json(Wrench{}));
  next(GovernorState::kStopped, 0.0);
  live->publish();  // nobody holds on before that, so that no tick wakes the gateway
  EXPECT_EQ(hand.newest().pose.position.x(), 2.5) << "its newest";
  EXPECT_NE(hand.newest().hand, old_hand);
}

TEST_F(LiveTopicsTest, APoseIsAsOldAsItsStampSaysOnceTheClockIsKnown) {
  begin(true);
  subscribe(*first, {"/palpate/client/echo"});
  const auto say = [&](const char* topic, const Json& message) {
    first->receive(Json{{"op", "publish"}, {"topic", topic}, {"msg", message}}.dump(), false);
    first->caught_up();
  };
  const auto pose = [&](double x, std::int64_t ms) {
    return Json{{"header", header({50, ms * 1'000'000}, "device", 0)}, {"pose", to_json(Pose{{x, 0, 0}})}};
  };
  clock.sleep_until(0.2);  // so that no time is 0
  say(kHand, pose(1.0, 0));
  EXPECT_NEAR(hand.newest().t, clock.now(), 0.1) << "nothing is known of its clock";
  const auto asked = all(*first)["/palpate/client/echo"];
  ASSERT_EQ(asked.size(), 1U);
  live->stale_after = 10.0;
  say("/palpate/client/echoed", header({50, 900'000'000}, "", asked[0]["seq"]));
  say(kHand, pose(2.0, 500));
  EXPECT_EQ(hand.newest().pose.position.x(), 2.0);
  EXPECT_NEAR(clock.now() - hand.newest().t, 0.4, 0.1) << "measured 0.4 s before the echo";

  live->stale_after = 0.2;
  say(kHand, pose(3.0, 501));
  EXPECT_EQ(hand.newest().pose.position.x(), 2.0) << "it is dropped";
  const auto told = all(*first)["status"];
  ASSERT_EQ(told.size(), 1U);
  EXPECT_THAT(told[0].get<std::string>(), HasSubstr("those older than 200 ms are dropped"));
  say(kHand, pose(3.0, 502));
  EXPECT_THAT(all(*first)["status"], IsEmpty()) << "told once a second";
}

// To find the ellipsoids of contacts, all Gaussians are sorted: no pose waits for that.
TEST_F(LiveTopicsTest, ContactsAreThereOnceTheirEllipsoidsHaveBeenLookedUpElsewhere) {
  begin(true);
  std::vector<std::pair<std::function<void()>, std::function<void()>>> jobs;
  live->elsewhere = [&](auto work, auto then) { jobs.emplace_back(std::move(work), std::move(then)); };
  const auto do_jobs = [&] {
    for (auto& [work, then] : std::exchange(jobs, {})) {
      work();
      then();
    }
  };
  subscribe(*first, {kContacts});
  const auto scene = test::scene_of({test::Splat{}});
  const auto index = [&] { return std::make_shared<const SceneIndex>(scene, SceneFilter{}, Similarity{}); };
  record.tool.position.setZero();
  tick();
  live->feel(index(), Tool());
  do_jobs();
  for (int k = 0; k < 10; ++k) live->publish();
  EXPECT_EQ(jobs.size(), 1U) << "asked for once";
  EXPECT_THAT(all(*first)[kContacts], IsEmpty());
  put(*second, {1, 2, 4}, "device");
  EXPECT_EQ(hand.newest().pose.position, Vector3d(1, 2, 4)) << "meanwhile a pose is taken";

  live->feel(index(), Tool());  // another scene, before the first is there
  do_jobs();
  for (int k = 0; k < 10; ++k) live->publish();
  EXPECT_THAT(all(*first)[kContacts], IsEmpty()) << "what was looked up is of the one before";
  do_jobs();
  for (int k = 0; k < 2; ++k) live->publish();
  EXPECT_FALSE(all(*first)[kContacts].empty());
}

TEST_F(LiveTopicsTest, PublishesAsOftenAsItSays) {
  begin();
  const std::vector<std::string> topics{"/palpate/measured_cp", "/palpate/measured_cv", kSpatial, kBody,
                                        "/palpate/proxy_cp",    "/palpate/tool",        kAnswer,  kContacts,
                                        "/palpate/diagnostics"};
  subscribe(*first, topics);
  const auto index =
      std::make_shared<const SceneIndex>(test::scene_of({test::Splat{}}), SceneFilter{}, Similarity{});
  live->feel(index, Tool());
  tick();
  for (int k = 0; k < 60; ++k) live->publish();
  auto told = all(*first);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(told[topics[k]].size(), 60U) << topics[k];
  EXPECT_THAT(told[kAnswer], IsEmpty()) << "it holds nothing";
  EXPECT_EQ(told[kContacts].size(), 30U + 1U) << "and the reset";
  EXPECT_EQ(told["/palpate/diagnostics"].size(), 20U);
  EXPECT_EQ(told["/palpate/measured_cp"][0]["pose"], to_json(record.tool));
  EXPECT_EQ(told["/palpate/measured_cp"][0]["header"]["frame_id"], "world");
  ASSERT_EQ(told["/palpate/tool"][0]["markers"].size(), 1U);
  EXPECT_EQ(told["/palpate/tool"][0]["markers"][0]["ns"], "tool");
}

TEST_F(LiveTopicsTest, AsksWhoHoldsItTenTimesASecondForItsTime) {
  constexpr const char* kEcho = "/palpate/client/echo";
  begin();
  for (Client* client : {first.get(), second.get()}) subscribe(*client, {kEcho});
  for (int k = 0; k < 60; ++k) live->publish();
  EXPECT_THAT(all(*first), IsEmpty()) << "nobody holds it";
  put(*first, {1, 0, 0}, "device");
  EXPECT_EQ(all(*first)[kEcho].size(), 1U) << "at once";
  for (int k = 0; k < 60; ++k) live->publish();
  EXPECT_EQ(all(*first)[kEcho].size(), 10U);
  EXPECT_THAT(all(*second), IsEmpty());
}

TEST_F(LiveTopicsTest, WhatIsNoEchoIsRefused) {
  begin();
  put(*first, {1, 0, 0}, "device");
  const auto refused = [&](const Json& message) {
    first->receive(Json{{"op", "publish"}, {"topic", "/palpate/client/echoed"}, {"msg", message}}.dump(),
                   false);
    return all(*first)["status"].size();
  };
  const Json stamp{{"secs", 7}, {"nsecs", 0}};
  EXPECT_EQ(refused({{"seq", 1}, {"stamp", stamp}}), 0U);
  EXPECT_EQ(refused({{"seq", -1}, {"stamp", stamp}}), 1U);
  EXPECT_EQ(refused({{"seq", 1e16}, {"stamp", stamp}}), 1U);
  EXPECT_EQ(refused({{"seq", 1}}), 1U);
}

TEST_F(LiveTopicsTest, ShowsWhatTheToolTouchesOfWhatIsFeltNow) {
  begin();
  subscribe(*first, {kContacts});
  live->publish();
  live->publish();
  EXPECT_THAT(all(*first), IsEmpty()) << "there is nothing to feel";
  const auto scene =
      test::scene_of({test::Splat{{0, 0, 0}}, test::Splat{{0, 0, 5}}, test::Splat{{0, 0, 5.01}}});
  live->feel(std::make_shared<const SceneIndex>(scene, SceneFilter{}, Similarity{}), Tool());
  tick();
  const auto next = [&] {
    live->publish();
    live->publish();
    return all(*first)[kContacts];
  };
  const auto ids = [](const Json& message, int action) {
    std::set<int> result;
    for (const Json& marker : message["markers"]) {
      if (marker["action"] == action) result.insert(marker["id"].get<int>());
    }
    return result;
  };
  const std::vector<Json> touching = next();
  ASSERT_EQ(touching.size(), 2U);
  EXPECT_EQ(touching[0]["markers"][0]["action"], 3) << "DELETEALL first";
  EXPECT_THAT(ids(touching[1], 0), ElementsAre(1, 2));
  record.tool.position = {0, 0, 0};
  tick();
  const std::vector<Json> elsewhere = next();
  ASSERT_EQ(elsewhere.size(), 1U);
  EXPECT_THAT(ids(elsewhere[0], 0), ElementsAre(0));
  EXPECT_THAT(ids(elsewhere[0], 2), ElementsAre(1, 2));
}

TEST_F(LiveTopicsTest, DiagnosticsHaveWhatIsDocumented) {
  begin();
  subscribe(*first, {"/palpate/diagnostics"});
  record.state = GovernorState::kActive;
  record.sent.force = {3, 4, 0};
  tick();
  live->publish();
  const Json status = all(*first)["/palpate/diagnostics"].at(0)["status"].at(0);
  EXPECT_EQ(status["name"], "palpate: servo");
  EXPECT_EQ(status["level"], 0);
  std::map<std::string, std::string> values;
  for (const Json& pair : status["values"]) values[pair["key"]] = pair["value"];
  for (const char* key :
       {"state",        "fault",          "advice",      "held_by",   "rate_hz",  "tick_us",
        "tick_mean_us", "tick_p50_us",    "tick_p99_us", "age_us",    "overruns", "contacts",
        "candidates",   "k_max",          "force_n",     "torque_nm", "margin",   "energy_mj",
        "stored_mj",    "port_energy_mj", "damping",     "clients"}) {
    EXPECT_EQ(values.count(key), 1U) << key;
  }
  EXPECT_EQ(values.size(), 22U);
  EXPECT_EQ(values["force_n"], "5");
  EXPECT_EQ(values["clients"], "2");
  EXPECT_EQ(values["fault"], "");
}

}  // namespace
}  // namespace palpate

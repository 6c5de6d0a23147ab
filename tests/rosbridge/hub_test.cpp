#include <palpate/rosbridge/hub.h>

#include <chrono>
#include <cstdlib>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <support/allocation_guard.h>
#include <support/cbor.h>

namespace palpate {
namespace {

using test::cbor_of;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class HubTest : public testing::Test {
 protected:
  HubTest() {
    hub.add_input("/in", "geometry_msgs/PoseStamped", [this](const Json& message, Client& from) {
      heard.push_back(message);
      heard_from = &from;
      if (message.contains("bad")) throw Refusal("that is bad");
    });
    hub.add_service("/double", "palpate/Double", [](const Json& arguments) {
      return Json{{"twice", 2.0 * number_field(arguments, "x", 0.0)}};
    });
  }

  std::unique_ptr<Client> connect() {
    return std::make_unique<Client>(
        hub, [this] { ++woken; }, [this] { return now; });
  }

  static void say(Client& client, const Json& message) { client.receive(message.dump(), false); }
  void say(const Json& message) { say(*client, message); }

  static std::vector<Json> all(Client& client) {
    std::vector<Json> messages;
    for (;;) {
      const bool told = client.has_next();
      const auto outgoing = client.next();
      EXPECT_EQ(outgoing.has_value(), told);
      if (!outgoing) return messages;
      messages.push_back(outgoing->binary ? decode_cbor(*outgoing->bytes) : decode_json(*outgoing->bytes));
    }
  }
  std::vector<Json> all() { return all(*client); }

  /// The one message that there is.
  Json one(Client& of) {
    const std::vector<Json> messages = all(of);
    EXPECT_EQ(messages.size(), 1U);
    return messages.empty() ? Json::object() : messages[0];
  }
  Json one() { return one(*client); }

  /// "topic message" of every publication there is.
  static std::vector<std::string> publications(Client& client) {
    std::vector<std::string> texts;
    for (const Json& message : all(client))
      texts.push_back(message.value("topic", "no topic") + ' ' + message.value("msg", Json()).dump());
    return texts;
  }
  std::vector<std::string> publications() { return publications(*client); }

  /// What is said is refused with words like these, and the id.
  void expect_status(const Json& message, const std::string& words) {
    say(message);
    const Json status = one();
    EXPECT_EQ(status.value("op", ""), "status") << message.dump();
    EXPECT_EQ(status.value("level", ""), "error");
    EXPECT_THAT(status.value("msg", ""), HasSubstr(words)) << message.dump();
    const Json id = message.is_object() ? message.value("id", Json()) : Json();
    EXPECT_EQ(status.value("id", Json()), id.is_string() ? id : Json()) << message.dump();
    EXPECT_EQ(client->fault(), "");
  }

  double now = 100.0;
  int woken = 0;
  std::vector<Json> heard;
  Client* heard_from = nullptr;
  Hub hub;
  Topic& topic = hub.add_topic("/a", "std_msgs/String");
  Topic& other = hub.add_topic("/b", "std_msgs/String");
  std::unique_ptr<Client> client = connect();
};

TEST_F(HubTest, WhatIsWrongIsToldWithTheIdOfTheMessage) {
  expect_status(Json::array({1}), "must be an object");
  expect_status("subscribe", "must be an object");
  expect_status({{"id", "1"}}, "'op' is missing");
  expect_status({{"op", nullptr}, {"id", "1"}}, "'op' is missing");
  expect_status({{"op", 3}, {"id", "2"}}, "'op' must be text");
  expect_status({{"op", "fly"}, {"id", "3"}}, "op 'fly' is not supported");
  expect_status({{"op", "fly"}, {"id", 3}}, "op 'fly' is not supported");
  for (const char* op : {"subscribe", "unsubscribe", "advertise", "publish"}) {
    expect_status({{"op", op}, {"id", "4"}}, "'topic' is missing");
    expect_status({{"op", op}, {"topic", ""}, {"id", "4"}}, "'topic' is missing");
    expect_status({{"op", op}, {"topic", 7}, {"id", "5"}}, "'topic' must be text");
  }
  expect_status({{"op", "call_service"}, {"id", "6"}}, "'service' is missing");
  expect_status({{"op", "subscribe"}, {"topic", "/nowhere"}, {"id", "7"}}, "there is no topic '/nowhere'");
  expect_status({{"op", "advertise"}, {"topic", "/a"}, {"id", "8"}}, "clients cannot publish on '/a'");
  expect_status({{"op", "publish"}, {"topic", "/a"}, {"msg", Json::object()}, {"id", "9"}},
                "clients cannot publish on '/a'");
  expect_status({{"op", "publish"}, {"topic", "/in"}, {"id", "10"}}, "'msg' is missing");
  expect_status({{"op", "publish"}, {"topic", "/in"}, {"msg", "text"}, {"id", "11"}},
                "'msg' must be an object");
  expect_status({{"op", "publish"}, {"topic", "/in"}, {"msg", {{"bad", 1}}}, {"id", "12"}}, "that is bad");
  expect_status({{"op", "subscribe"}, {"topic", "/a"}, {"compression", "png"}, {"id", "13"}},
                "compression 'png' is not supported");
  expect_status({{"op", "subscribe"}, {"topic", "/a"}, {"throttle_rate", "fast"}, {"id", "14"}},
                "'throttle_rate'");
  expect_status({{"op", "subscribe"}, {"topic", "/a"}, {"queue_length", Json::array()}, {"id", "15"}},
                "'queue_length'");
  EXPECT_FALSE(topic.is_watched());

  client->receive("{", false);
  EXPECT_THAT(one().value("msg", ""), HasSubstr("not valid JSON"));
  client->receive("\xff", true);
  EXPECT_THAT(one().value("msg", ""), HasSubstr("CBOR"));
}

TEST_F(HubTest, WhatWasSaidIsQuotedInShortAndAsUtf8) {
  expect_status({{"op", std::string(1000, 'x')}}, '\'' + std::string(80, 'x') + "...'");
  // The euro sign is three bytes, and 80 is in the midst of one; and in CBOR text may be anything.
  std::string euros;
  for (int k = 0; k < 50; ++k) euros += "\u20ac";
  expect_status({{"op", euros}}, "is not supported");
  client->receive(cbor_of({{"op", "a\xff\xfe"}, {"id", "\xff"}}), true);
  const auto outgoing = client->next();
  ASSERT_TRUE(outgoing);
  EXPECT_NO_THROW(decode_json(*outgoing->bytes));
}

TEST_F(HubTest, TypesAreAcceptedInBothNotations) {
  for (const char* type : {"std_msgs/String", "std_msgs/msg/String", "*", ""}) {
    say({{"op", "subscribe"}, {"topic", "/a"}, {"type", type}});
    EXPECT_THAT(all(), IsEmpty()) << type;
  }
  for (const char* type : {"geometry_msgs/PoseStamped", "geometry_msgs/msg/PoseStamped"}) {
    say({{"op", "advertise"}, {"topic", "/in"}, {"type", type}});
    EXPECT_THAT(all(), IsEmpty()) << type;
  }
  expect_status({{"op", "subscribe"}, {"topic", "/a"}, {"type", "std_msgs/Int32"}, {"id", "x"}},
                "/a is of type std_msgs/String, not 'std_msgs/Int32'");
  expect_status({{"op", "subscribe"}, {"topic", "/a"}, {"type", "String"}}, "is of type");
  expect_status({{"op", "advertise"}, {"topic", "/in"}, {"type", "std_msgs/String"}}, "is of type");
}

TEST_F(HubTest, PublicationsComeToWhomSubscribesInTheirOrder) {
  topic.publish(1);
  say({{"op", "subscribe"}, {"topic", "/a"}, {"queue_length", 3}});
  EXPECT_TRUE(topic.is_watched());
  EXPECT_FALSE(other.is_watched());
  topic.publish({{"data", "x"}});
  other.publish(2);
  EXPECT_EQ(woken, 1);
  EXPECT_EQ(one(), (Json{{"op", "publish"}, {"topic", "/a"}, {"msg", {{"data", "x"}}}}));
  topic.publish(3);
  topic.publish(4);
  EXPECT_THAT(publications(), ElementsAre("/a 3", "/a 4"));
  EXPECT_EQ(client->next(), std::nullopt);
}

TEST_F(HubTest, ANameWithoutItsSlashIsTheSame) {
  say({{"op", "subscribe"}, {"topic", "a"}});
  topic.publish(1);
  EXPECT_THAT(publications(), ElementsAre("/a 1"));
  say({{"op", "publish"}, {"topic", "in"}, {"msg", {{"x", 1}}}});
  EXPECT_THAT(heard, ElementsAre(Json{{"x", 1}}));
  say({{"op", "unsubscribe"}, {"topic", "a"}});
  EXPECT_FALSE(topic.is_watched());
}

TEST_F(HubTest, TwoSubscriptionsOfATopicAreOneUntilBothAreGone) {
  say({{"op", "subscribe"}, {"topic", "/a"}, {"id", "one"}});
  say({{"op", "subscribe"}, {"topic", "/a"}, {"id", "two"}});
  topic.publish(1);
  EXPECT_THAT(publications(), ElementsAre("/a 1")) << "it comes once";
  say({{"op", "unsubscribe"}, {"topic", "/a"}, {"id", "one"}});
  topic.publish(2);
  EXPECT_THAT(publications(), ElementsAre("/a 2"));
  say({{"op", "unsubscribe"}, {"topic", "/a"}, {"id", "nobody"}});
  topic.publish(3);
  EXPECT_THAT(publications(), ElementsAre("/a 3"));
  topic.publish(4);
  say({{"op", "unsubscribe"}, {"topic", "/a"}, {"id", "two"}});
  EXPECT_THAT(publications(), IsEmpty()) << "what waits goes with it";
  EXPECT_FALSE(topic.is_watched());
  topic.publish(5);
  EXPECT_THAT(publications(), IsEmpty());
  say({{"op", "unsubscribe"}, {"topic", "/a"}, {"id", "two"}});
  EXPECT_THAT(all(), IsEmpty()) << "once more does no harm";
}

TEST_F(HubTest, UnsubscribingWithoutAnIdEndsAll) {
  say({{"op", "subscribe"}, {"topic", "/a"}, {"id", "one"}});
  say({{"op", "subscribe"}, {"topic", "/a"}, {"id", "two"}});
  say({{"op", "unsubscribe"}, {"topic", "/a"}});
  EXPECT_FALSE(topic.is_watched());
}

TEST_F(HubTest, ThrottleLeavesOutWhatComesTooSoon) {
  say({{"op", "subscribe"}, {"topic", "/a"}, {"throttle_rate", 100}, {"queue_length", 100}});
  // 60 a second for a second: one in six. The clock's rounding must not make that one in seven.
  int sent = 0;
  for (int k = 0; k < 60; ++k) {
    now = 100.0 + k / 60.0;
    topic.publish(k);
    const auto got = publications();
    EXPECT_TRUE(got.empty() || k % 6 == 0) << k;
    sent += static_cast<int>(got.size());
  }
  EXPECT_EQ(sent, 10);
}

TEST_F(HubTest, ThrottleIsThatOfWhomWantsMost) {
  say({{"op", "subscribe"}, {"topic", "/a"}, {"throttle_rate", 10'000}, {"id", "slow"}});
  topic.publish(1);
  EXPECT_THAT(publications(), ElementsAre("/a 1"));
  now += 1.0;
  say({{"op", "subscribe"}, {"topic", "/a"}, {"id", "fast"}});
  topic.publish(2);
  EXPECT_THAT(publications(), ElementsAre("/a 2")) << "the wait of the slow one is none of the fast one's";
}

TEST_F(HubTest, AThrottleBelowZeroIsNone) {
  say({{"op", "subscribe"}, {"topic", "/a"}, {"throttle_rate", -5}, {"queue_length", -5}});
  topic.publish(1);
  topic.publish(2);
  EXPECT_THAT(publications(), ElementsAre("/a 2"));
}

TEST_F(HubTest, TheQueueKeepsTheNewest) {
  say({{"op", "subscribe"}, {"topic", "/a"}, {"queue_length", 3}});
  say({{"op", "subscribe"}, {"topic", "/b"}});
  for (int k = 1; k <= 5; ++k) {
    topic.publish(k);
    other.publish(k);
  }
  EXPECT_THAT(publications(), ElementsAre("/a 3", "/b 5", "/a 4", "/a 5"));
  say({{"op", "subscribe"}, {"topic", "/a"}, {"queue_length", 1e9}});
  for (int k = 1; k <= 150; ++k) topic.publish(k);
  const auto kept = publications();
  EXPECT_EQ(kept.size(), Client::kMostQueued);
  EXPECT_EQ(kept.front(), "/a 51");
  EXPECT_EQ(kept.back(), "/a 150");
}

TEST_F(HubTest, TopicsTakeTurns) {
  say({{"op", "subscribe"}, {"topic", "/a"}, {"queue_length", 10}});
  for (int k = 1; k <= 3; ++k) topic.publish(k);
  say({{"op", "subscribe"}, {"topic", "/b"}, {"queue_length", 10}});
  for (int k = 1; k <= 2; ++k) other.publish(k);
  EXPECT_THAT(publications(), ElementsAre("/a 1", "/b 1", "/a 2", "/b 2", "/a 3"));
}

TEST_F(HubTest, ATopicThatNeverWaitsDoesNotKeepAnotherFromItsTurn) {
  say({{"op", "subscribe"}, {"topic", "/a"}});
  say({{"op", "subscribe"}, {"topic", "/b"}});
  topic.publish(0);
  other.publish(0);
  int of_other = 0;
  for (int k = 1; k <= 10; ++k) {
    const auto outgoing = client->next();
    ASSERT_TRUE(outgoing);
    of_other += decode_json(*outgoing->bytes).value("topic", "") == "/b" ? 1 : 0;
    topic.publish(k);  // there is always one of it
    other.publish(k);
  }
  EXPECT_EQ(of_other, 5);
}

TEST_F(HubTest, AnswersGoBeforeTopics) {
  say({{"op", "subscribe"}, {"topic", "/a"}, {"queue_length", 2}});
  topic.publish(1);
  topic.publish(2);
  say({{"op", "call_service"}, {"service", "/double"}, {"args", {{"x", 1}}}, {"id", "1"}});
  say({{"op", "fly"}});
  std::vector<std::string> ops;
  for (const Json& message : all()) ops.push_back(message.value("op", ""));
  EXPECT_THAT(ops, ElementsAre("service_response", "status", "publish", "publish"));
}

TEST_F(HubTest, ALatchedTopicComesToWhomSubscribesLate) {
  Topic& latched = hub.add_topic("/latched", "std_msgs/String", true);
  say({{"op", "subscribe"}, {"topic", "/latched"}, {"throttle_rate", 1e6}});
  EXPECT_THAT(publications(), IsEmpty()) << "nothing was published yet";
  latched.publish(1);
  latched.publish(2);
  EXPECT_THAT(publications(), ElementsAre("/latched 2"));
  latched.publish(3);
  EXPECT_THAT(publications(), ElementsAre("/latched 3")) << "whatever the throttle";
  const auto late = connect();
  say(*late, {{"op", "subscribe"}, {"topic", "/latched"}});
  EXPECT_THAT(publications(*late), ElementsAre("/latched 3"));
  EXPECT_THAT(publications(), IsEmpty());
}

TEST_F(HubTest, AResetGoesFirstToAClientThatMissedMoreThanItsReach) {
  topic.set_reset("reset", 3);
  topic.publish(1);
  say({{"op", "subscribe"}, {"topic", "/a"}});
  topic.publish(2);
  EXPECT_THAT(publications(), ElementsAre("/a \"reset\"", "/a 2")) << "it has nothing yet";
  topic.publish(3);
  EXPECT_THAT(publications(), ElementsAre("/a 3"));
  for (int k = 4; k <= 6; ++k) topic.publish(k);
  EXPECT_THAT(publications(), ElementsAre("/a 6")) << "the third since the last one still says all";
  for (int k = 7; k <= 10; ++k) topic.publish(k);
  EXPECT_THAT(publications(), ElementsAre("/a \"reset\"", "/a 10"));
  // Between the reset and the message that it was for, that is made obsolete.
  for (int k = 11; k <= 14; ++k) topic.publish(k);
  EXPECT_EQ(decode_json(*client->next()->bytes)["msg"], "reset");
  topic.publish(15);
  EXPECT_THAT(publications(), ElementsAre("/a 15"));
}

TEST_F(HubTest, AResetInCborIsInCbor) {
  topic.set_reset("reset", 3);
  say({{"op", "subscribe"}, {"topic", "/a"}, {"compression", "cbor"}});
  topic.publish(1);
  const auto first = client->next();
  ASSERT_TRUE(first && first->binary);
  EXPECT_EQ(decode_cbor(*first->bytes)["msg"], "reset");
  EXPECT_THAT(publications(), ElementsAre("/a 1"));
}

TEST_F(HubTest, CborSaysTheSameAsText) {
  const auto second = connect();
  say({{"op", "subscribe"}, {"topic", "/a"}});
  second->receive(cbor_of({{"op", "subscribe"}, {"topic", "/a"}, {"compression", "cbor"}}), true);
  topic.publish({{"x", {1, -2.5, nullptr}}, {"s", "\u20ac"}});
  const auto text = client->next(), binary = second->next();
  ASSERT_TRUE(text && binary);
  EXPECT_FALSE(text->binary);
  EXPECT_TRUE(binary->binary);
  EXPECT_EQ(decode_cbor(*binary->bytes), decode_json(*text->bytes));
  EXPECT_EQ(decode_cbor(*binary->bytes)["op"], "publish");
  // Answers are text all the same.
  second->receive("\xff", true);
  EXPECT_FALSE(second->next()->binary);
}

TEST_F(HubTest, IsEncodedOnceForAll) {
  const auto second = connect();
  for (Client* c : {client.get(), second.get()}) say(*c, {{"op", "subscribe"}, {"topic", "/a"}});
  topic.publish(std::string(1000, 'x'));
  EXPECT_EQ(client->next()->bytes.get(), second->next()->bytes.get());
}

TEST_F(HubTest, BytesLiveLongerThanTheTopicAndTheClient) {
  say({{"op", "subscribe"}, {"topic", "/a"}});
  topic.publish("first");
  const auto outgoing = client->next();
  topic.publish("second");
  client.reset();
  EXPECT_EQ(decode_json(*outgoing->bytes)["msg"], "first");
}

TEST_F(HubTest, PublishesToAllButOne) {
  const auto second = connect();
  for (Client* c : {client.get(), second.get()}) say(*c, {{"op", "subscribe"}, {"topic", "/a"}});
  topic.publish(1, client.get());
  EXPECT_THAT(publications(), IsEmpty());
  EXPECT_THAT(publications(*second), ElementsAre("/a 1"));
}

TEST_F(HubTest, PublishesToOneAlone) {
  const auto second = connect(), third = connect();
  for (Client* c : {client.get(), second.get()}) say(*c, {{"op", "subscribe"}, {"topic", "/a"}});
  topic.publish_to(*second, 1);
  topic.publish_to(*third, 2);  // does not subscribe
  EXPECT_THAT(publications(), IsEmpty());
  EXPECT_THAT(publications(*second), ElementsAre("/a 1"));
  EXPECT_THAT(publications(*third), IsEmpty());
}

TEST_F(HubTest, WhatAClientPublishesIsHeardWithItsSender) {
  say({{"op", "advertise"}, {"topic", "/in"}, {"type", "geometry_msgs/PoseStamped"}});
  say({{"op", "publish"}, {"topic", "/in"}, {"msg", {{"x", 1}}}});
  client->receive(cbor_of({{"op", "publish"}, {"topic", "/in"}, {"msg", {{"x", 2}}}}), true);
  say({{"op", "unadvertise"}, {"topic", "/in"}});
  EXPECT_THAT(heard, ElementsAre(Json{{"x", 1}}, Json{{"x", 2}}));
  EXPECT_EQ(heard_from, client.get());
  EXPECT_THAT(all(), IsEmpty());
}

TEST_F(HubTest, CallsAreAnsweredWithTheirId) {
  const auto call = [&](Json message) {
    message["op"] = "call_service";
    say(message);
    return one();
  };
  EXPECT_EQ(call({{"service", "/double"}, {"args", {{"x", 4}}}, {"id", "7"}}),
            (Json{{"op", "service_response"},
                  {"service", "/double"},
                  {"id", "7"},
                  {"result", true},
                  {"values", {{"twice", 8.0}}}}));
  for (const Json& none : {Json(), Json::array(), Json::object()})
    EXPECT_EQ(call({{"service", "double"}, {"args", none}})["values"]["twice"], 0.0);
  EXPECT_FALSE(call({{"service", "/double"}}).contains("id"));
  EXPECT_EQ(call({{"service", "/double"}, {"id", 9}})["id"], 9);

  const auto refused = [&](const Json& message, const char* words) {
    const Json answer = call(message);
    EXPECT_EQ(answer["op"], "service_response");
    EXPECT_EQ(answer["result"], false);
    EXPECT_EQ(answer["id"], "7");
    EXPECT_THAT(answer["values"].get<std::string>(), HasSubstr(words));
  };
  refused({{"service", "/nowhere"}, {"id", "7"}}, "there is no service '/nowhere'");
  refused({{"service", "/double"}, {"args", {1}}, {"id", "7"}}, "'args' must be an object");
  refused({{"service", "/double"}, {"args", ""}, {"id", "7"}}, "'args' must be an object");
  refused({{"service", "/double"}, {"args", {{"x", "four"}}}, {"id", "7"}}, "'x' must be a finite number");
}

// A client must not be able to end the program, whatever a service fails to expect.
TEST_F(HubTest, AnyExceptionOfAServiceIsAFailedAnswer) {
  hub.add_service("/fails", "x/Y", [](const Json&) -> Json { throw std::logic_error("nobody knows why"); });
  hub.add_slow_service("/fails_to_begin", "x/Y",
                       [](const Json&, const Reply&) { throw std::out_of_range("too far"); });
  const auto expect_failed = [this](const char* service, const char* why) {
    say({{"op", "call_service"}, {"service", service}, {"id", "k"}});
    EXPECT_EQ(one(), (Json{{"op", "service_response"},
                           {"service", service},
                           {"id", "k"},
                           {"result", false},
                           {"values", why}}));
    EXPECT_EQ(client->fault(), "");
  };
  expect_failed("/fails", "nobody knows why");
  expect_failed("/fails_to_begin", "too far");
}

TEST_F(HubTest, AnyExceptionOfAListenerIsAnError) {
  hub.add_input("/fragile", "x/Y", [](const Json&, Client&) { throw std::logic_error("nobody knows why"); });
  expect_status({{"op", "publish"}, {"topic", "/fragile"}, {"msg", Json::object()}}, "nobody knows why");
  EXPECT_EQ(client->fault(), "");
}

TEST_F(HubTest, AServiceWithoutArgumentsIsCalledWhateverComesAsSuch) {
  int calls = 0;
  hub.add_service("/stop", "std_srvs/Trigger", [&](const Json& arguments) {
    EXPECT_EQ(arguments, Json::object());
    ++calls;
    return Json{{"success", true}, {"message", ""}};
  });
  const std::vector<Json> all{Json(), Json::array(), {1, 2}, "now", "", true, 4, {{"data", true}}};
  for (const Json& args : all) {
    say({{"op", "call_service"}, {"service", "/stop"}, {"args", args}});
    EXPECT_EQ(one()["result"], true) << args;
  }
  EXPECT_EQ(calls, static_cast<int>(all.size()));
}

TEST_F(HubTest, SetLevelNoneSilencesStatusAndNothingElse) {
  say({{"op", "set_level"}, {"level", "none"}});
  say({{"op", "fly"}});
  EXPECT_THAT(all(), IsEmpty());
  say({{"op", "call_service"}, {"service", "/nowhere"}});
  EXPECT_EQ(one()["result"], false);
  say({{"op", "set_level"}, {"level", "error"}});
  say({{"op", "fly"}});
  EXPECT_EQ(one()["op"], "status");
}

TEST_F(HubTest, HasSixtyFourSubscriptionsAtMost) {
  for (std::size_t k = 0; k <= Client::kMostSubscriptions; ++k)
    hub.add_topic("/t" + std::to_string(k), "x/Y");
  for (std::size_t k = 0; k < Client::kMostSubscriptions; ++k)
    say({{"op", "subscribe"}, {"topic", "/t" + std::to_string(k)}});
  EXPECT_THAT(all(), IsEmpty());
  expect_status({{"op", "subscribe"}, {"topic", "/t64"}, {"id", "x"}}, "more than 64 subscriptions");
  EXPECT_FALSE(hub.topics().at("/t64").is_watched());
  say({{"op", "subscribe"}, {"topic", "/t0"}, {"id", "again"}});
  EXPECT_THAT(all(), IsEmpty()) << "one that is there may change";
  say({{"op", "unsubscribe"}, {"topic", "/t0"}});
  say({{"op", "subscribe"}, {"topic", "/t64"}});
  EXPECT_THAT(all(), IsEmpty());
}

TEST_F(HubTest, HasSixtyFourIdsOfATopicAtMost) {
  for (std::size_t k = 0; k < Client::kMostSubscriptions; ++k)
    say({{"op", "subscribe"}, {"topic", "/a"}, {"id", std::to_string(k)}});
  EXPECT_THAT(all(), IsEmpty());
  expect_status({{"op", "subscribe"}, {"topic", "/a"}, {"id", "x"}}, "more than 64 subscriptions of /a");
  say({{"op", "subscribe"}, {"topic", "/a"}, {"id", "7"}});
  EXPECT_THAT(all(), IsEmpty());
}

// Two megabytes at once and as many a second later are allowed, in however few messages; a byte more is not.
TEST_F(HubTest, TooManyBytesASecondAreAFault) {
  const auto most = static_cast<std::size_t>(Client::kMostBytes);
  EXPECT_TRUE(client->admit(most / 2));
  EXPECT_TRUE(client->admit(most / 2));
  now += 0.5;
  EXPECT_TRUE(client->admit(most / 2));
  EXPECT_EQ(client->fault(), "");
  EXPECT_FALSE(client->admit(1));
  EXPECT_THAT(client->fault(), HasSubstr("bytes a second"));
  now += 10.0;
  EXPECT_FALSE(client->admit(1)) << "it is on its way out";
}

TEST_F(HubTest, TooManyMessagesASecondAreAFault) {
  const auto most = static_cast<int>(Client::kMostMessages);
  const auto send = [&](int count) {
    for (int k = 0; k < count; ++k) client->receive(R"({"op": "unadvertise"})", false);
  };
  send(most);
  EXPECT_EQ(client->fault(), "");
  now += 0.1;
  send(most / 10 - 1);
  EXPECT_EQ(client->fault(), "");
  now += 60.0;  // what was not used in a minute is not saved up
  send(most);
  EXPECT_EQ(client->fault(), "");
  send(1);
  EXPECT_THAT(client->fault(), HasSubstr("more than 5000 messages a second"));
  now += 60.0;
  say({{"op", "publish"}, {"topic", "/in"}, {"msg", {{"x", 1}}}});
  EXPECT_THAT(heard, IsEmpty()) << "it stays at that";
  EXPECT_NE(client->fault(), "");
}

TEST_F(HubTest, AnswersThatNobodyReadsAreAFault) {
  for (std::size_t k = 0; k < Client::kMostAnswers; ++k) say({{"op", "fly"}});
  EXPECT_EQ(client->fault(), "");
  EXPECT_EQ(all().size(), Client::kMostAnswers);
  for (std::size_t k = 0; k < Client::kMostAnswers; ++k) say({{"op", "fly"}});
  EXPECT_EQ(client->fault(), "") << "what was read counts no longer";
  say({{"op", "fly"}});
  EXPECT_THAT(client->fault(), HasSubstr("does not read"));
}

TEST_F(HubTest, AnswersThatAreLargeAreAFaultSooner) {
  hub.add_service("/large", "x/Y", [](const Json&) { return Json{{"s", std::string(1 << 20, 'x')}}; });
  for (int k = 0; k < 3; ++k) say({{"op", "call_service"}, {"service", "/large"}});
  EXPECT_EQ(client->fault(), "");
  EXPECT_EQ(all().size(), 3U);
  for (int k = 0; k < 3; ++k) say({{"op", "call_service"}, {"service", "/large"}});
  EXPECT_EQ(client->fault(), "") << "what was read counts no longer";
  say({{"op", "call_service"}, {"service", "/large"}});
  EXPECT_THAT(client->fault(), HasSubstr("does not read"));
}

TEST_F(HubTest, AClientThatGoesIsForgotten) {
  const Client* left = nullptr;
  std::size_t watched_by = 9;
  hub.on_leave.emplace_back([&](const Client& gone) {
    left = &gone;
    watched_by = hub.client_count();
  });
  EXPECT_EQ(hub.client_count(), 1U);
  const auto second = connect();
  for (Client* c : {client.get(), second.get()}) say(*c, {{"op", "subscribe"}, {"topic", "/a"}});
  topic.publish(1);
  EXPECT_EQ(hub.client_count(), 2U);
  const Client* gone = client.get();
  client.reset();
  EXPECT_EQ(left, gone);
  EXPECT_EQ(watched_by, 1U);
  topic.publish(2);
  EXPECT_THAT(publications(*second), ElementsAre("/a 2"));
}

TEST_F(HubTest, AClientThatCannotBeToldForLackOfMemoryIsAFault) {
  const Client::Decoded nonsense = Client::decode("nonsense", false);
  ASSERT_NE(nonsense.refusal, "");
  test::fail_allocations(1);
  EXPECT_NO_THROW(client->take(nonsense));
  EXPECT_EQ(client->fault(), "no memory");
  const auto another = connect();
  // One allocation is that of the refusal, the next that of the status.
  const Client::Decoded unknown = Client::decode(R"({"op":"fly"})", false);
  test::fail_allocations(2);
  EXPECT_NO_THROW(another->take(unknown));
  test::fail_allocations(0);
  EXPECT_EQ(another->fault(), "no memory");
}

TEST_F(HubTest, AListenerThatRunsOutOfMemoryEndsNothingWhenAClientGoes) {
  bool told = false;
  hub.on_leave.emplace_back([](const Client&) { throw std::bad_alloc(); });
  hub.on_leave.emplace_back([&](const Client&) { told = true; });
  client.reset();
  EXPECT_TRUE(told) << "the other listeners hear of it";
  EXPECT_EQ(hub.client_count(), 0U);
}

// Whoever is woken may send at once, find the peer gone, and close.
TEST_F(HubTest, AClientMayLeaveATopicWhileItIsPublished) {
  std::unique_ptr<Client> second;
  const auto first = std::make_unique<Client>(
      hub,
      [&] {
        say(*second, {{"op", "unsubscribe"}, {"topic", "/a"}});
      },
      [] { return 0.0; });
  second = connect();
  for (Client* c : {first.get(), second.get()}) say(*c, {{"op", "subscribe"}, {"topic", "/a"}});
  EXPECT_NO_THROW(topic.publish(1));
  EXPECT_THAT(publications(*first), ElementsAre("/a 1"));
  EXPECT_THAT(publications(*second), IsEmpty());
}

TEST_F(HubTest, AClientMayBeDestroyedWhileATopicIsPublished) {
  std::unique_ptr<Client> second;
  const auto first = std::make_unique<Client>(
      hub, [&] { second.reset(); }, [] { return 0.0; });
  second = connect();
  for (Client* c : {first.get(), second.get()}) say(*c, {{"op", "subscribe"}, {"topic", "/a"}});
  EXPECT_NO_THROW(topic.publish(1));
  EXPECT_EQ(second, nullptr);
  EXPECT_THAT(publications(*first), ElementsAre("/a 1"));
}

class RosapiTest : public HubTest {
 protected:
  RosapiTest() { add_rosapi(hub); }

  Json ask(const std::string& service, const Json& args = Json::object()) {
    say({{"op", "call_service"}, {"service", "/rosapi/" + service}, {"args", args}});
    const Json answer = one();
    EXPECT_EQ(answer["result"], true) << answer.dump();
    return answer["values"];
  }
};

TEST_F(RosapiTest, TellsTopicsOfBothDirectionsWithTheirTypes) {
  const Json topics = ask("topics");
  EXPECT_EQ(topics["topics"], (Json{"/a", "/b", "/in"}));
  EXPECT_EQ(topics["types"], (Json{"std_msgs/String", "std_msgs/String", "geometry_msgs/PoseStamped"}));
  const Json raw = ask("topics_and_raw_types");
  EXPECT_EQ(raw["topics"], topics["topics"]);
  EXPECT_EQ(raw["types"], topics["types"]);
  EXPECT_EQ(raw["typedefs_full_text"].size(), 3U);
  EXPECT_EQ(ask("topic_type", {{"topic", "/a"}})["type"], "std_msgs/String");
  EXPECT_EQ(ask("topic_type", {{"topic", "/in"}})["type"], "geometry_msgs/PoseStamped");
  EXPECT_EQ(ask("topic_type", {{"topic", "/nowhere"}})["type"], "");
  EXPECT_EQ(ask("topic_type")["type"], "");
  EXPECT_EQ(ask("topics_for_type", {{"type", "std_msgs/String"}})["topics"], (Json{"/a", "/b"}));
  EXPECT_EQ(ask("topics_for_type", {{"type", "x/Y"}})["topics"], Json::array());
}

TEST_F(RosapiTest, TellsServicesWithTheirTypes) {
  const std::vector<std::string> services = ask("services")["services"];
  EXPECT_THAT(services, Contains("/double"));
  EXPECT_THAT(services, Contains("/rosapi/services"));
  EXPECT_EQ(ask("service_type", {{"service", "/double"}})["type"], "palpate/Double");
  EXPECT_EQ(ask("service_type", {{"service", "/rosapi/topics"}})["type"], "rosapi/Topics");
  EXPECT_EQ(ask("service_type", {{"service", "/nowhere"}})["type"], "");
  EXPECT_EQ(ask("services_for_type", {{"type", "palpate/Double"}})["services"], Json::array({"/double"}));
  for (const std::string& service : services)
    EXPECT_NE(ask("service_type", {{"service", service}})["type"], "") << service;
}

TEST_F(RosapiTest, IsOneNode) {
  EXPECT_EQ(ask("nodes")["nodes"], Json::array({"/palpate"}));
  EXPECT_EQ(ask("service_node", {{"service", "/double"}})["node"], "/palpate");
  const Json details = ask("node_details", {{"node", "/palpate"}});
  EXPECT_EQ(details["publishing"], (Json{"/a", "/b"}));
  EXPECT_EQ(details["subscribing"], Json::array({"/in"}));
  EXPECT_EQ(details["services"], ask("services")["services"]);
  EXPECT_EQ(ask("action_servers")["action_servers"], Json::array());
}

TEST_F(RosapiTest, TellsWhoHasATopic) {
  EXPECT_EQ(ask("publishers", {{"topic", "/a"}})["publishers"], Json::array({"/palpate"}));
  EXPECT_EQ(ask("publishers", {{"topic", "/in"}})["publishers"], Json::array());
  EXPECT_EQ(ask("subscribers", {{"topic", "/in"}})["subscribers"], Json::array({"/palpate"}));
  EXPECT_EQ(ask("subscribers", {{"topic", "/nowhere"}})["subscribers"], Json::array());
}

TEST_F(RosapiTest, TellsWhatMessagesAndServicesAreMadeOf) {
  const Json text = ask("message_details", {{"type", "std_msgs/msg/String"}})["typedefs"];
  ASSERT_EQ(text.size(), 1U);
  EXPECT_EQ(text[0]["type"], "std_msgs/String");
  EXPECT_EQ(ask("service_request_details", {{"type", "std_srvs/SetBool"}})["typedefs"][0]["fieldnames"],
            Json::array({"data"}));
  EXPECT_EQ(ask("service_response_details", {{"type", "std_srvs/SetBool"}})["typedefs"][0]["fieldnames"],
            (Json{"success", "message"}));
  // All that it offers itself.
  for (const auto& [name, offer] : hub.services()) {
    if (!name.starts_with("/rosapi/")) continue;
    for (const char* half : {"service_request_details", "service_response_details"})
      EXPECT_GE(ask(half, {{"type", offer.type}})["typedefs"].size(), 1U) << name << " " << half;
  }
}

TEST_F(RosapiTest, RefusesTypesThatThereAreNot) {
  for (const auto& [service, type, words] :
       {std::tuple{"message_details", "x/Y", "there is no message type 'x/Y'"},
        std::tuple{"message_details", "", "there is no message type ''"},
        std::tuple{"service_request_details", "std_msgs/String",
                   "there is no service type 'std_msgs/String'"},
        std::tuple{"service_response_details", "x/Y", "there is no service type 'x/Y'"}}) {
    say({{"op", "call_service"}, {"service", std::string("/rosapi/") + service}, {"args", {{"type", type}}}});
    const Json answer = one();
    EXPECT_EQ(answer["result"], false);
    EXPECT_EQ(answer["values"], words);
  }
}

TEST_F(RosapiTest, TellsTheTime) {
  const auto clock = [] {
    return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  };
  const double before = clock();
  const Json time = ask("get_time")["time"];
  const double told = time["secs"].get<double>() + 1e-9 * time["nsecs"].get<double>();
  EXPECT_GE(told, before - 1e-5);  // of doubles this far from 1970
  EXPECT_LE(told, clock() + 1e-5);
  EXPECT_LT(time["nsecs"].get<std::int64_t>(), 1'000'000'000);
}

TEST_F(RosapiTest, RefusesNamesThatAreNoText) {
  say({{"op", "call_service"}, {"service", "/rosapi/topic_type"}, {"args", {{"topic", 5}}}});
  const Json answer = one();
  EXPECT_EQ(answer["result"], false);
  EXPECT_EQ(answer["values"], "'topic' must be text");
}

}  // namespace
}  // namespace palpate

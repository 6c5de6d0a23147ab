// Messages as ROS 1 defines and encodes them.
#include <palpate/rosbridge/ros_definition.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/rosbridge/hub.h>

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string bytes_of(std::initializer_list<int> values) { return {values.begin(), values.end()}; }

TEST(RosDefinition, HasTheTypesThatATypeIsMadeOf) {
  const std::string text = ros_definition("geometry_msgs/PoseStamped");
  EXPECT_THAT(text, StartsWith("std_msgs/Header header\ngeometry_msgs/Pose pose\n" + std::string(80, '=') +
                               "\nMSG: std_msgs/Header\nuint32 seq\n"));
  for (const char* type : {"geometry_msgs/Pose", "geometry_msgs/Point", "geometry_msgs/Quaternion"})
    EXPECT_THAT(text, HasSubstr("MSG: " + std::string(type) + "\n"));
  EXPECT_EQ(ros_definition("palpate/SetString"), "");
}

TEST(RosDefinition, AMessageIsItsFieldsInOrder) {
  const Json header{{"seq", 7}, {"stamp", {{"secs", 1}, {"nsecs", 258}}}, {"frame_id", "ab"}};
  EXPECT_EQ(ros_bytes("std_msgs/Header", header),
            bytes_of({7, 0, 0, 0, 1, 0, 0, 0, 2, 1, 0, 0, 2, 0, 0, 0, 'a', 'b'}));
  EXPECT_EQ(
      ros_bytes("geometry_msgs/Point", {{"x", 1.0}, {"y", -2.0}, {"z", 0.5}}),
      bytes_of({0, 0, 0, 0, 0, 0, 0xf0, 0x3f, 0, 0, 0, 0, 0, 0, 0, 0xc0, 0, 0, 0, 0, 0, 0, 0xe0, 0x3f}));
  const Json status{{"level", 2}, {"values", {{{"key", "k"}, {"value", ""}}}}};
  EXPECT_EQ(ros_bytes("diagnostic_msgs/DiagnosticStatus", status),
            bytes_of({2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 'k', 0, 0, 0, 0}));
}

TEST(RosDefinition, WhatIsMissingOrOfAnotherKindIsZero) {
  EXPECT_EQ(ros_bytes("std_msgs/String", Json::object()), bytes_of({0, 0, 0, 0}));
  EXPECT_EQ(ros_bytes("std_msgs/ColorRGBA", 5), std::string(16, '\0'));
  EXPECT_EQ(ros_bytes("visualization_msgs/MarkerArray", {{"markers", "none"}}), bytes_of({0, 0, 0, 0}));
  EXPECT_EQ(ros_bytes("std_msgs/Header", {{"seq", "x"}, {"stamp", 3}, {"frame_id", 4}}),
            std::string(16, '\0'));
  EXPECT_EQ(ros_bytes("std_msgs/Header", {{"stamp", {{"nsecs", 3}}}}),
            std::string(8, '\0') + bytes_of({3, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(RosDefinition, ASubscriberOfCborRawGetsTheBytes) {
  Hub hub;
  Topic& topic = hub.add_topic("/told", "std_msgs/String");
  hub.add_topic("/own", "palpate/Own");
  Client client(
      hub, [] {}, [] { return 0.0; });
  client.receive(R"({"op":"subscribe","topic":"/told","compression":"cbor-raw"})", false);
  topic.publish({{"data", "hi"}});
  const auto sent = client.next();
  ASSERT_TRUE(sent && sent->binary);
  const Json message = Json::from_cbor(*sent->bytes);
  EXPECT_EQ(message["op"], "publish");
  EXPECT_EQ(message["topic"], "/told");
  EXPECT_GT(message["msg"]["secs"], 0);
  const Json::binary_t& raw = message["msg"]["bytes"].get_binary();
  EXPECT_EQ(std::string(raw.begin(), raw.end()), bytes_of({2, 0, 0, 0, 'h', 'i'}));
  client.receive(R"({"op":"subscribe","topic":"/own","compression":"cbor-raw"})", false);
  const auto refused = client.next();
  ASSERT_TRUE(refused);
  EXPECT_THAT(*refused->bytes, HasSubstr("palpate/Own is not a ROS message type"));
}

}  // namespace
}  // namespace palpate

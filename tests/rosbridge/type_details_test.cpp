// Types as rosapi tells them; what is expected is worked out from its source (objectutils.py) and ROS's
// definitions.
#include <palpate/rosbridge/type_details.h>

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/rosbridge/ros_definition.h>

namespace palpate {
namespace {

using testing::ElementsAre;

std::vector<std::string> types_of(const Json& defs) {
  std::vector<std::string> types;
  for (const Json& def : defs) types.push_back(def["type"]);
  return types;
}

TEST(TypeDetails, AFieldHasATypeALengthAndAnExample) {
  const Json defs = message_details("diagnostic_msgs/DiagnosticStatus");
  EXPECT_EQ(defs[0], Json::parse(R"({
    "type": "diagnostic_msgs/DiagnosticStatus",
    "fieldnames": ["level", "name", "message", "hardware_id", "values"],
    "fieldtypes": ["byte", "string", "string", "string", "diagnostic_msgs/KeyValue"],
    "fieldarraylen": [-1, -1, -1, -1, 0],
    "examples": ["0", "", "", "", "[]"],
    "constnames": ["ERROR", "OK", "STALE", "WARN"],
    "constvalues": ["2", "0", "3", "1"]})"));
  EXPECT_EQ(defs[1], Json::parse(R"({
    "type": "diagnostic_msgs/KeyValue", "fieldnames": ["key", "value"], "fieldtypes": ["string", "string"],
    "fieldarraylen": [-1, -1], "examples": ["", ""], "constnames": [], "constvalues": []})"));
  EXPECT_EQ(defs.size(), 2U);
}

TEST(TypeDetails, WhatATypeIsMadeOfComesOnceAndDepthFirst) {
  const Json defs = message_details("visualization_msgs/MarkerArray");
  EXPECT_THAT(types_of(defs),
              ElementsAre("visualization_msgs/MarkerArray", "visualization_msgs/Marker", "std_msgs/Header",
                          "time", "geometry_msgs/Pose", "geometry_msgs/Point", "geometry_msgs/Quaternion",
                          "geometry_msgs/Vector3", "std_msgs/ColorRGBA", "duration"));
  EXPECT_EQ(defs[3], Json::parse(R"({
    "type": "time", "fieldnames": ["secs", "nsecs"], "fieldtypes": ["int32", "int32"], "fieldarraylen": [-1, -1],
    "examples": ["0", "0"], "constnames": [], "constvalues": []})"));
  const Json& marker = defs[1];
  EXPECT_EQ(
      marker["constnames"],
      Json::parse(R"(["ADD", "ARROW", "CUBE", "CUBE_LIST", "CYLINDER", "DELETE", "DELETEALL", "LINE_LIST",
              "LINE_STRIP", "MESH_RESOURCE", "MODIFY", "POINTS", "SPHERE", "SPHERE_LIST", "TEXT_VIEW_FACING",
              "TRIANGLE_LIST"])"));
  EXPECT_EQ(marker["constvalues"],
            Json::parse(R"(["0", "0", "1", "6", "3", "2", "3", "5", "4", "10", "0", "8", "2",
              "7", "9", "11"])"));
  EXPECT_EQ(
      marker["examples"],
      Json::parse(
          R"(["{}", "", "0", "0", "0", "{}", "{}", "{}", "{}", "False", "[]", "[]", "", "", "False"])"));
  EXPECT_EQ(types_of(message_details("geometry_msgs/Point")),
            types_of(message_details("geometry_msgs/msg/Point")));
  EXPECT_EQ(message_details("geometry_msgs/Point")[0]["examples"], Json::parse(R"(["0.0", "0.0", "0.0"])"));
}

TEST(TypeDetails, WhatRosHasByItselfIsMadeOfNothing) {
  EXPECT_EQ(message_details("float64"), Json::array());
  EXPECT_EQ(message_details("string"), Json::array());
  EXPECT_THAT(types_of(message_details("duration")), ElementsAre("duration"));
}

TEST(TypeDetails, AServiceHasTwoHalves) {
  EXPECT_EQ(service_request_details("std_srvs/Trigger"), Json::parse(R"([{
    "type": "std_srvs/TriggerRequest", "fieldnames": [], "fieldtypes": [], "fieldarraylen": [], "examples": [],
    "constnames": [], "constvalues": []}])"));
  EXPECT_EQ(service_response_details("std_srvs/srv/SetBool"), Json::parse(R"([{
    "type": "std_srvs/SetBoolResponse", "fieldnames": ["success", "message"], "fieldtypes": ["bool", "string"],
    "fieldarraylen": [-1, -1], "examples": ["False", ""], "constnames": [], "constvalues": []}])"));
  const Json defs = service_response_details("rosapi/MessageDetails");
  EXPECT_THAT(types_of(defs), ElementsAre("rosapi/MessageDetailsResponse", "rosapi/TypeDef"));
  // The shape of the answer is what the answer says of itself.
  EXPECT_EQ(defs[1]["fieldnames"].size(), defs[1].size());
  for (const Json& name : defs[1]["fieldnames"])
    EXPECT_TRUE(defs[1].contains(name.get<std::string>())) << name;
  EXPECT_EQ(defs[1]["fieldarraylen"], Json::parse("[-1, 0, 0, 0, 0, 0, 0]"));
}

TEST(TypeDetails, AConstantIsNoField) {
  const std::string text = ros_definition("diagnostic_msgs/DiagnosticStatus");
  EXPECT_NE(text.find("byte ERROR=2\n"), std::string::npos);
  EXPECT_EQ(ros_bytes("diagnostic_msgs/DiagnosticStatus", Json{{"level", 2}}).size(), 1U + 4 * 4);
}

TEST(TypeDetails, WhatIsNotKnownIsRefused) {
  EXPECT_THROW(message_details("std_msgs/Nothing"), Refusal);
  EXPECT_THROW(message_details(""), Refusal);
  EXPECT_THROW(service_request_details("std_msgs/String"), Refusal);
  EXPECT_THROW(service_response_details(std::string(1000, 'x')), Refusal);
}

}  // namespace
}  // namespace palpate

#include <palpate/rosbridge/ros_type.h>

#include <algorithm>
#include <functional>
#include <map>
#include <sstream>

namespace palpate {
namespace {

struct Definition {
  std::string_view type, text;
};

constexpr Definition kMessages[] = {
    {"std_msgs/Header", "uint32 seq\ntime stamp\nstring frame_id\n"},
    {"std_msgs/String", "string data\n"},
    {"std_msgs/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"},
    {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
    {"geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"},
    {"geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n"},
    {"geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"},
    {"geometry_msgs/TwistStamped", "std_msgs/Header header\ngeometry_msgs/Twist twist\n"},
    {"geometry_msgs/Wrench", "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n"},
    {"geometry_msgs/WrenchStamped", "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n"},
    {"visualization_msgs/Marker",
     "uint8 ARROW=0\nuint8 CUBE=1\nuint8 SPHERE=2\nuint8 CYLINDER=3\nuint8 LINE_STRIP=4\nuint8 LINE_LIST=5\n"
     "uint8 CUBE_LIST=6\nuint8 SPHERE_LIST=7\nuint8 POINTS=8\nuint8 TEXT_VIEW_FACING=9\n"
     "uint8 MESH_RESOURCE=10\nuint8 TRIANGLE_LIST=11\nuint8 ADD=0\nuint8 MODIFY=0\nuint8 DELETE=2\n"
     "uint8 DELETEALL=3\n"
     "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n"
     "geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nduration lifetime\nbool frame_locked\n"
     "geometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring text\nstring mesh_resource\n"
     "bool mesh_use_embedded_materials\n"},
    {"visualization_msgs/MarkerArray", "visualization_msgs/Marker[] markers\n"},
    {"diagnostic_msgs/KeyValue", "string key\nstring value\n"},
    {"diagnostic_msgs/DiagnosticStatus",
     "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\n"
     "byte level\nstring name\nstring message\nstring hardware_id\ndiagnostic_msgs/KeyValue[] values\n"},
    {"diagnostic_msgs/DiagnosticArray",
     "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n"},
    {"palpate/ContactPlane", "geometry_msgs/Point point\ngeometry_msgs/Vector3 normal\n"},
    {"palpate/LocalModel",
     "std_msgs/Header header\ngeometry_msgs/Point position\npalpate/ContactPlane[] planes\n"
     "float64 stiffness\nfloat64 damping\nfloat64 friction\nfloat64 share\n"},
    {"rosapi/TypeDef",
     "string type\nstring[] fieldnames\nstring[] fieldtypes\nint32[] fieldarraylen\nstring[] examples\n"
     "string[] constnames\nstring[] constvalues\n"},
};

struct ServiceDefinition {
  std::string_view type, request, response;
};

constexpr std::string_view kDone = "bool success\nstring message\n";
constexpr std::string_view kTypeDefs = "rosapi/TypeDef[] typedefs\n";

constexpr ServiceDefinition kServices[] = {
    {"std_srvs/Trigger", "", kDone},
    {"std_srvs/SetBool", "bool data\n", kDone},
    {"palpate/SetString", "string data\n", kDone},
    {"palpate/SetParameters", "string json\n", kDone},
    {"rosapi/Topics", "", "string[] topics\nstring[] types\n"},
    {"rosapi/TopicsAndRawTypes", "", "string[] topics\nstring[] types\nstring[] typedefs_full_text\n"},
    {"rosapi/TopicsForType", "string type\n", "string[] topics\n"},
    {"rosapi/TopicType", "string topic\n", "string type\n"},
    {"rosapi/Publishers", "string topic\n", "string[] publishers\n"},
    {"rosapi/Subscribers", "string topic\n", "string[] subscribers\n"},
    {"rosapi/Services", "", "string[] services\n"},
    {"rosapi/ServicesForType", "string type\n", "string[] services\n"},
    {"rosapi/ServiceType", "string service\n", "string type\n"},
    {"rosapi/ServiceNode", "string service\n", "string node\n"},
    {"rosapi/Nodes", "", "string[] nodes\n"},
    {"rosapi/NodeDetails", "string node\n", "string[] subscribing\nstring[] publishing\nstring[] services\n"},
    {"rosapi/GetActionServers", "", "string[] action_servers\n"},
    {"rosapi/GetTime", "", "time time\n"},
    {"rosapi/GetParamNames", "", "string[] names\n"},
    {"rosapi/HasParam", "string name\n", "bool exists\n"},
    {"rosapi/GetParam", "string name\nstring default\n", "string value\n"},
    {"rosapi/SetParam", "string name\nstring value\n", ""},
    {"rosapi/MessageDetails", "string type\n", kTypeDefs},
    {"rosapi/ServiceRequestDetails", "string type\n", kTypeDefs},
    {"rosapi/ServiceResponseDetails", "string type\n", kTypeDefs},
};

RosType parsed(std::string_view text) {
  RosType type;
  type.text = text;
  std::istringstream lines{std::string(text)};
  for (RosField field; lines >> field.type >> field.name;) {
    const auto equals = field.name.find('=');
    field.value = equals == std::string::npos ? "" : field.name.substr(equals + 1);
    field.name.resize(std::min(equals, field.name.size()));
    field.is_array = field.type.ends_with("[]");
    if (field.is_array) field.type.resize(field.type.size() - 2);
    (equals == std::string::npos ? type.fields : type.constants).push_back(field);
  }
  return type;
}

std::map<std::string, RosType, std::less<>> all_types() {
  std::map<std::string, RosType, std::less<>> all;
  for (const Definition& one : kMessages) all[std::string(one.type)] = parsed(one.text);
  for (const ServiceDefinition& one : kServices) {
    all[std::string(one.type) + "Request"] = parsed(one.request);
    all[std::string(one.type) + "Response"] = parsed(one.response);
  }
  for (auto& [name, type] : all) type.name = name;
  return all;
}

}  // namespace

const RosType* find_ros_type(std::string_view name) {
  static const auto all = all_types();
  const auto at = all.find(name);
  return at == all.end() ? nullptr : &at->second;
}

std::string plain_type(std::string type) {
  for (const std::string_view part : {"/msg/", "/srv/"}) {
    if (const auto at = type.find(part); at != std::string::npos) type.erase(at, part.size() - 1);
  }
  return type;
}

}  // namespace palpate

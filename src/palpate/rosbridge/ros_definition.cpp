#include <palpate/rosbridge/ros_definition.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <sstream>
#include <string_view>
#include <vector>

namespace palpate {
namespace {

static_assert(std::endian::native == std::endian::little, "as ROS encodes numbers");

struct Definition {
  std::string_view type, fields;
};

/// Fields as in ROS's own .msg files, without constants and comments.
constexpr std::array<Definition, 19> kDefinitions{{
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
     "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n"
     "geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nduration lifetime\nbool frame_locked\n"
     "geometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring text\nstring mesh_resource\n"
     "bool mesh_use_embedded_materials\n"},
    {"visualization_msgs/MarkerArray", "visualization_msgs/Marker[] markers\n"},
    {"diagnostic_msgs/KeyValue", "string key\nstring value\n"},
    {"diagnostic_msgs/DiagnosticStatus",
     "byte level\nstring name\nstring message\nstring hardware_id\ndiagnostic_msgs/KeyValue[] values\n"},
    {"diagnostic_msgs/DiagnosticArray",
     "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n"},
    {"palpate/ContactPlane", "geometry_msgs/Point point\ngeometry_msgs/Vector3 normal\n"},
    {"palpate/LocalModel",
     "std_msgs/Header header\ngeometry_msgs/Point position\npalpate/ContactPlane[] planes\nfloat64 "
     "stiffness\n"
     "float64 damping\nfloat64 friction\nfloat64 share\n"},
}};

const Definition* find(std::string_view type) {
  const auto* const at = std::find_if(kDefinitions.begin(), kDefinitions.end(),
                                      [&](const Definition& known) { return known.type == type; });
  return at == kDefinitions.end() ? nullptr : at;
}

struct Field {
  std::string type, name;
  bool is_array = false;
};

std::vector<Field> fields_of(const Definition& definition) {
  std::istringstream lines{std::string(definition.fields)};
  std::vector<Field> fields;
  for (Field field; lines >> field.type >> field.name; fields.push_back(field)) {
    field.is_array = field.type.ends_with("[]");
    if (field.is_array) field.type.resize(field.type.size() - 2);
  }
  return fields;
}

void add_types(const Definition& definition, std::vector<const Definition*>& found) {
  if (std::find(found.begin(), found.end(), &definition) != found.end()) return;
  found.push_back(&definition);
  for (const Field& field : fields_of(definition))
    if (const Definition* const inner = find(field.type)) add_types(*inner, found);
}

template <class Number>
void put(std::string& out, Number number) {
  const auto bytes = std::bit_cast<std::array<char, sizeof(Number)>>(number);
  out.append(bytes.data(), bytes.size());
}

/// JSON has no NaN.
double real(const Json& value) {
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::int64_t whole(const Json& value) {
  if (value.is_boolean()) return value.get<bool>() ? 1 : 0;
  return value.is_number() ? static_cast<std::int64_t>(value.get<double>()) : 0;
}

void put_basic(std::string& out, const std::string& type, const Json& value) {
  if (type == "float64") return put(out, value.is_null() ? 0.0 : real(value));
  if (type == "float32") return put(out, static_cast<float>(value.is_null() ? 0.0 : real(value)));
  if (type == "bool" || type == "byte") return put(out, static_cast<std::int8_t>(whole(value)));
  if (type == "int32" || type == "uint32") return put(out, static_cast<std::uint32_t>(whole(value)));
  if (type == "string") {
    const std::string text = value.is_string() ? value.get<std::string>() : std::string();
    put(out, static_cast<std::uint32_t>(text.size()));
    out += text;
    return;
  }
  // time and duration
  for (const char* part : {"secs", "nsecs"})
    put(out, static_cast<std::uint32_t>(value.is_object() && value.contains(part) ? whole(value[part]) : 0));
}

void put_message(std::string& out, const Definition& definition, const Json& message);

void put_value(std::string& out, const std::string& type, const Json& value) {
  if (const Definition* const inner = find(type)) return put_message(out, *inner, value);
  put_basic(out, type, value);
}

void put_message(std::string& out, const Definition& definition, const Json& message) {
  static const Json none;
  for (const Field& field : fields_of(definition)) {
    const bool has = message.is_object() && message.contains(field.name);
    const Json& value = has ? message[field.name] : none;
    if (!field.is_array) {
      put_value(out, field.type, value);
      continue;
    }
    const std::size_t count = value.is_array() ? value.size() : 0;
    put(out, static_cast<std::uint32_t>(count));
    for (std::size_t k = 0; k < count; ++k) put_value(out, field.type, value[k]);
  }
}

}  // namespace

std::string ros_definition(const std::string& type) {
  const Definition* const main = find(type);
  if (main == nullptr) return {};
  std::vector<const Definition*> all;
  add_types(*main, all);
  std::string text(main->fields);
  for (const Definition* inner : all) {
    if (inner == main) continue;
    text += std::string(80, '=') + "\nMSG: " + std::string(inner->type) + "\n" + std::string(inner->fields);
  }
  return text;
}

std::string ros_bytes(const std::string& type, const Json& message) {
  std::string out;
  put_message(out, *find(type), message);
  return out;
}

}  // namespace palpate

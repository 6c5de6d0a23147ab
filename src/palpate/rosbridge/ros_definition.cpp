#include <palpate/rosbridge/ros_definition.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

#include <palpate/rosbridge/ros_type.h>

namespace palpate {
namespace {

static_assert(std::endian::native == std::endian::little, "as ROS encodes numbers");

void add_types(const RosType& type, std::vector<const RosType*>& found) {
  if (std::find(found.begin(), found.end(), &type) != found.end()) return;
  found.push_back(&type);
  for (const RosField& field : type.fields)
    if (const RosType* const inner = find_ros_type(field.type)) add_types(*inner, found);
}

template <class Number>
void put(std::string& out, Number number) {
  const auto bytes = std::bit_cast<std::array<char, sizeof(Number)>>(number);
  out.append(bytes.data(), bytes.size());
}

/// Returns a number; NaN for anything else.
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

void put_message(std::string& out, const RosType& type, const Json& message);

void put_value(std::string& out, const std::string& type, const Json& value) {
  if (const RosType* const inner = find_ros_type(type)) return put_message(out, *inner, value);
  put_basic(out, type, value);
}

void put_message(std::string& out, const RosType& type, const Json& message) {
  static const Json none;
  for (const RosField& field : type.fields) {
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
  const RosType* const main = find_ros_type(type);
  if (main == nullptr) return {};
  std::vector<const RosType*> all;
  add_types(*main, all);
  std::string text(main->text);
  for (const RosType* inner : all) {
    if (inner == main) continue;
    text += std::string(80, '=') + "\nMSG: " + std::string(inner->name) + "\n" + std::string(inner->text);
  }
  return text;
}

std::string ros_bytes(const std::string& type, const Json& message) {
  std::string out;
  put_message(out, *find_ros_type(type), message);
  return out;
}

}  // namespace palpate

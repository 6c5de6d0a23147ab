#include <palpate/rosbridge/type_details.h>

#include <algorithm>
#include <array>
#include <set>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/rosbridge/ros_type.h>

namespace palpate {
namespace {

constexpr std::array<std::string_view, 12> kNumbers{"byte",   "int8",    "uint8",   "int16",
                                                    "uint16", "int32",   "uint32",  "int64",
                                                    "uint64", "float32", "float64", "bool"};

bool is_basic(std::string_view type) {
  return type == "string" || std::find(kNumbers.begin(), kNumbers.end(), type) != kNumbers.end();
}

bool is_time(std::string_view type) { return type == "time" || type == "duration"; }

/// Returns the default value of a field, as Python's str() prints it.
std::string example_of(const RosField& field) {
  if (field.is_array) return "[]";
  if (!is_basic(field.type)) return "{}";
  if (field.type == "string") return "";
  if (field.type == "bool") return "False";
  return field.type.starts_with("float") ? "0.0" : "0";
}

/// Returns the TypeDef of a time or duration, which have no definition; field names as in rosapi.
Json time_def(const std::string& type) {
  return {{"type", type},
          {"fieldnames", {"secs", "nsecs"}},
          {"fieldtypes", {"int32", "int32"}},
          {"fieldarraylen", {-1, -1}},
          {"examples", {"0", "0"}},
          {"constnames", Json::array()},
          {"constvalues", Json::array()}};
}

Json type_def(const RosType& type) {
  Json def{{"type", type.name}};
  for (const char* list :
       {"fieldnames", "fieldtypes", "fieldarraylen", "examples", "constnames", "constvalues"})
    def[list] = Json::array();
  for (const RosField& field : type.fields) {
    def["fieldnames"].push_back(field.name);
    def["fieldtypes"].push_back(field.type);
    def["fieldarraylen"].push_back(field.is_array ? 0 : -1);
    def["examples"].push_back(example_of(field));
  }
  std::vector<RosField> constants = type.constants;
  std::sort(constants.begin(), constants.end(),
            [](const RosField& a, const RosField& b) { return a.name < b.name; });
  for (const RosField& constant : constants) {
    def["constnames"].push_back(constant.name);
    def["constvalues"].push_back(constant.value);
  }
  return def;
}

[[noreturn]] void refuse(const char* what, const std::string& type) {
  constexpr std::size_t kShown = 80;
  throw Refusal(fmt::format("there is no {} '{}'", what, printable(type.substr(0, kShown))));
}

/// Adds `type`, and its nested types that are not in `seen`.
void add(const RosType& type, std::set<std::string>& seen, Json& defs) {
  defs.push_back(type_def(type));
  for (const RosField& field : type.fields) {
    if (is_basic(field.type) || !seen.insert(field.type).second) continue;
    is_time(field.type) ? defs.push_back(time_def(field.type)) : add(*find_ros_type(field.type), seen, defs);
  }
}

Json details_of(const RosType& type) {
  Json defs = Json::array();
  std::set<std::string> seen{std::string(type.name)};
  add(type, seen, defs);
  return defs;
}

Json half_of_service(const std::string& service, const char* half) {
  const RosType* const found = find_ros_type(plain_type(service) + half);
  if (found == nullptr) refuse("service type", service);
  return details_of(*found);
}

}  // namespace

Json message_details(const std::string& type) {
  if (is_basic(type)) return Json::array();
  if (is_time(type)) return Json::array({time_def(type)});
  const RosType* const found = find_ros_type(plain_type(type));
  if (found == nullptr) refuse("message type", type);
  return details_of(*found);
}

Json service_request_details(const std::string& service) { return half_of_service(service, "Request"); }

Json service_response_details(const std::string& service) { return half_of_service(service, "Response"); }

}  // namespace palpate

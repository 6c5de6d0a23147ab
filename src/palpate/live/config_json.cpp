#include <palpate/live/config_json.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <palpate/base/error.h>
#include <palpate/haptics/tool_file.h>
#include <palpate/live/config_fields.h>
#include <palpate/live/value_text.h>

namespace palpate {
namespace {

/// Homogeneous transformation from the captured frame to the world, in column-major order.
Json matrix_of(const Similarity& s) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = s.scale * s.orthogonal();
  m.topRightCorner<3, 1>() = s.translation;
  return std::vector<double>(m.data(), m.data() + m.size());
}

Json tool_json(const Tool& tool) {
  Json json = Json::array();
  for (const ToolPart& part : tool.parts())
    json.push_back({{"name", part.name},
                    {"semi_axes", numbers(part.semi_axes)},
                    {"position", numbers(part.pose.position)},
                    {"orientation", numbers(part.pose.orientation)}});
  return json;
}

/// Returns the value of a field as JSON.
struct JsonOf {
  const LiveConfig& config;

  Json operator()(const OptionalField& field) const { return field.member(config).value_or(0.0); }
  Json operator()(const ChoiceField& field) const { return field.chosen(config); }
  Json operator()(const NumbersField& field) const { return field.get(config); }
  Json operator()(const ToolField& field) const { return tool_json(field.member(config)); }
  template <class Scalar>
  Json operator()(const Scalar& field) const {
    return field.member(config);
  }
};

double number_in(const Json& value, std::string_view name, double low, double high) {
  const double number = value.is_number() ? value.get<double>() : std::nan("");
  if (!(number >= low && number <= high))
    throw Refusal(fmt::format("'{}' must be a number from {} to {}", name, low, high));
  return number;
}

std::string text_of(const Json& value, std::string_view name) {
  if (!value.is_string()) throw Refusal(fmt::format("'{}' must be text", name));
  return value.get<std::string>();
}

std::vector<double> numbers_of(const Json& value, std::string_view name, std::size_t count, double most) {
  if (!value.is_array() || value.size() != count)
    throw Refusal(fmt::format("'{}' must be {} numbers", name, count));
  std::vector<double> result;
  for (const Json& one : value) result.push_back(number_in(one, name, -most, most));
  return result;
}

ToolPart part_of(const Json& value) {
  if (!value.is_object()) throw Refusal("'tool' must be ellipsoids, each with 'semi_axes'");
  ToolPart part;
  part.name = text_field(value, "name");
  const auto a = numbers_of(field(value, "semi_axes"), "semi_axes", 3, kMaxToolAxis);
  if (*std::min_element(a.begin(), a.end()) < kMinToolAxis)
    throw Refusal(fmt::format("'semi_axes' must be {} m or more", kMinToolAxis));
  part.semi_axes = {a[0], a[1], a[2]};
  if (value.contains("position")) {
    const auto p = numbers_of(value["position"], "position", 3, kCoordinateMax);
    part.pose.position = {p[0], p[1], p[2]};
  }
  if (value.contains("orientation")) {
    const auto q = numbers_of(value["orientation"], "orientation", 4, kQuaternionMax);
    try {
      part.pose.orientation = parse_quaternion(q.data());
    } catch (const BadValue& error) {
      throw Refusal(fmt::format("'orientation': {}", error.what()));
    }
  }
  return part;
}

Tool tool_of(const Json& value) {
  if (!value.is_array() || value.empty() || value.size() > kMaxToolParts)
    throw Refusal(fmt::format("'tool' must be 1 to {} ellipsoids", kMaxToolParts));
  std::vector<ToolPart> parts;
  for (const Json& part : value) parts.push_back(part_of(part));
  return Tool(std::move(parts));
}

/// Sets a field from a value sent by a client.
struct JsonSetter {
  LiveConfig& config;
  const Json& value;
  std::string_view name;

  void operator()(const FlagField& field) const {
    if (!value.is_boolean()) throw Refusal(fmt::format("'{}' must be true or false", name));
    field.member(config) = value.get<bool>();
  }
  void operator()(const TextField& field) const { field.member(config) = text_of(value, name); }
  void operator()(const CountField& field) const {
    field.member(config) = static_cast<int>(number_in(value, name, field.least, field.most));
  }
  void operator()(const NumberField& field) const {
    field.member(config) = number_in(value, name, field.least, field.most);
  }
  void operator()(const OptionalField& field) const {
    const double number = number_in(value, name, 0.0, field.most_parameter);
    field.member(config).reset();
    if (number > 0.0) field.member(config) = number;
  }
  void operator()(const ChoiceField& field) const {
    const auto at = std::find(field.names.begin(), field.names.end(), text_of(value, name));
    if (at == field.names.end())
      throw Refusal(fmt::format("'{}' must be one of {}", name, fmt::join(field.names, ", ")));
    field.set(config, static_cast<std::size_t>(at - field.names.begin()));
  }
  void operator()(const NumbersField& field) const {
    if (field.unset != nullptr && value.is_array() && value.empty()) return field.unset(config);
    const auto all = numbers_of(value, name, field.count, field.most_parameter);
    try {
      field.set(config, all);
    } catch (const BadValue& error) {
      throw Refusal(fmt::format("'{}': {}", name, error.what()));
    }
  }
  void operator()(const ToolField& field) const { field.member(config) = tool_of(value); }
};

/// Unsets the fields that replace the field of this name.
void unset_what_replaces(std::string_view name, LiveConfig& config) {
  for (const ConfigField& other : config_fields()) {
    const auto* optional = std::get_if<OptionalField>(&other.type);
    if (optional != nullptr && !name.empty() && other.traits.excludes == name)
      optional->member(config).reset();
  }
}

/// Sets the fields below one level of parameter names: "", or for example "filter.".
void change_level(LiveConfig& config, const Json& wanted, const std::string& where,
                  const std::string& level) {
  if (!wanted.is_object()) throw Refusal(fmt::format("'{}' must be an object", where));
  for (const auto& [name, value] : wanted.items()) {
    // A name with a dot is unknown: levels are nested objects.
    const std::string full = name.find('.') == std::string::npos ? level + name : std::string();
    std::set<std::string_view> known;
    const ConfigField* found = nullptr;
    bool is_level = false;
    for (const ConfigField& field : config_fields()) {
      if (!field.parameter.starts_with(level) || field.parameter.empty() || field.traits.read_only) continue;
      const std::string_view rest = field.parameter.substr(level.size());
      known.insert(rest.substr(0, rest.find('.')));
      if (field.parameter == full) found = &field;
      is_level = is_level || (!full.empty() && field.parameter.starts_with(full + '.'));
    }
    if (found != nullptr) {
      std::visit(JsonSetter{config, value, name}, found->type);
      unset_what_replaces(found->name, config);
    } else if (is_level) {
      change_level(config, value, name, full + '.');
    } else {
      throw Refusal(fmt::format("{} has no '{}'; it has {}", where, printable(name.substr(0, 40)),
                                fmt::join(known, ", ")));
    }
  }
}

}  // namespace

Json settings_json(const LiveConfig& config) {
  Json json;
  for (const ConfigField& field : config_fields()) {
    if (field.parameter.empty()) continue;
    std::string path(1, '/');
    path += field.parameter;
    std::replace(path.begin(), path.end(), '.', '/');
    json[Json::json_pointer(path)] = std::visit(JsonOf{config}, field.type);
  }
  json["registration"]["matrix"] = matrix_of(config.scene.world_from_scene());
  return json;
}

void change_settings(LiveConfig& config, const Json& wanted) {
  change_level(config, wanted, "parameters", "");
}

}  // namespace palpate

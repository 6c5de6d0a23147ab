#include "node_settings.h"

#include <algorithm>
#include <optional>

#include <palpate/base/error.h>
#include <palpate/live/config_fields.h>
#include <palpate/live/config_toml.h>
#include <palpate/live/value_text.h>

namespace palpate::node {
namespace {

/// Set before all others, whatever the order.
constexpr const char* kConfig = "config";
constexpr double kMostDecimation = 1e6;

std::optional<std::string> find(const std::vector<NodeParameter>& parameters, std::string_view name) {
  const auto at = std::find_if(parameters.begin(), parameters.end(),
                               [&](const NodeParameter& p) { return p.name == name; });
  return at == parameters.end() ? std::nullopt : std::optional(at->value);
}

/// The device itself is CrtkArguments', and a node has no gateway.
bool is_field(const ConfigField& field) {
  switch (field.group) {
    case ConfigGroup::kScene:
    case ConfigGroup::kTool:
    case ConfigGroup::kForce:
    case ConfigGroup::kLoop: return !field.name.empty();
    case ConfigGroup::kDevice: return field.name.starts_with("workspace-");
    default: return false;
  }
}

bool set_field(LiveConfig& live, const NodeParameter& parameter) {
  std::string name = parameter.name;
  std::replace(name.begin(), name.end(), '_', '-');
  for (const ConfigField& field : config_fields()) {
    if (field.name != name || !is_field(field)) continue;
    set_from_text(field, live, parameter.value);
    return true;
  }
  return false;
}

std::string frame_name(const std::string& text) {
  if (text.empty() || text.front() == '/' ||
      std::any_of(text.begin(), text.end(), [](unsigned char c) { return c <= ' '; }))
    throw BadValue("'" + printable(text) +
                   "' is no name of a frame of tf: letters and digits, no slash first");
  return text;
}

int decimation_of(const std::string& text) {
  const double number = parse_number(text);
  if (!(number >= 1.0 && number <= kMostDecimation) || number != static_cast<int>(number))
    throw BadValue(printable(text) + " is no whole number of 1 or more");
  return static_cast<int>(number);
}

/// \returns false if there is no parameter of that name.
bool set(NodeSettings& settings, const NodeParameter& parameter) {
  const auto& [name, value] = parameter;
  if (name == "scene") {
    settings.live.scene.path = value;
  } else if (name == "cloud_decimation") {
    settings.decimation = decimation_of(value);
  } else if (name == "world_frame") {
    settings.world_frame = frame_name(value);
  } else if (name == "device_frame") {
    settings.device_frame = value.empty() ? value : frame_name(value);
  } else if (name == "tf_prefix") {
    settings.tf_prefix = value.empty() ? value : frame_name(value);
  } else if (name != kConfig && name != "device") {
    return set_field(settings.live, parameter);
  }
  return true;
}

}  // namespace

NodeSettings read_node_settings(const std::string& kind, const std::vector<NodeParameter>& parameters) {
  const auto config = find(parameters, kConfig);
  NodeSettings settings{.live = config && !config->empty() ? read_live_config(*config) : LiveConfig(),
                        .device = parse_crtk_arguments(kind, find(parameters, "device").value_or("/omni"))};
  for (const NodeParameter& parameter : parameters) {
    try {
      if (!set(settings, parameter))
        throw Error("there is no parameter '{}'; docs/ros.md lists them", printable(parameter.name));
    } catch (const BadValue& error) {
      throw Error("parameter '{}': {}", printable(parameter.name), error.what());
    }
  }
  if (settings.device_frame.empty()) settings.device_frame = settings.tf_prefix + "device";
  return settings;
}

}  // namespace palpate::node

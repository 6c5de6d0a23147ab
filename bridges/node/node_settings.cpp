#include "node_settings.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <sstream>
#include <system_error>

#include <palpate/base/error.h>
#include <palpate/live/config_fields.h>
#include <palpate/live/config_toml.h>
#include <palpate/live/hand_setup.h>
#include <palpate/live/value_text.h>

namespace palpate::node {
namespace {

/// Name of the parameter that is applied before all others.
constexpr const char* kConfig = "config";
constexpr const char* kHands = "hands";
constexpr const char* kDevice = "device";
constexpr double kMostDecimation = 1e6;

/// Value of a parameter; nothing if it is missing or empty.
std::optional<std::string> find(const std::vector<NodeParameter>& parameters, std::string_view name) {
  const auto at = std::find_if(parameters.begin(), parameters.end(),
                               [&](const NodeParameter& p) { return p.name == name; });
  return at == parameters.end() || at->value.empty() ? std::nullopt : std::optional(at->value);
}

/// Parameters of a hand, without its name as prefix.
std::vector<NodeParameter> parameters_of(const std::string& hand, const std::vector<NodeParameter>& all) {
  std::vector<NodeParameter> own;
  for (const auto& [name, value] : all)
    if (name.starts_with(hand + "/")) own.push_back({name.substr(hand.size() + 1), value});
  return own;
}

/// Returns whether a hand has a parameter for `field`. CrtkArguments describes the device; a node has no
/// gateway. \param first whether it is the first hand, whose scene the others share
bool is_field(const ConfigField& field, bool first) {
  switch (field.group) {
    case ConfigGroup::kScene: return first && !field.name.empty();
    case ConfigGroup::kTool:
    case ConfigGroup::kForce:
    case ConfigGroup::kLoop: return !field.name.empty();
    case ConfigGroup::kDevice: return field.name.starts_with("workspace-");
    default: return false;
  }
}

bool set_field(NodeHand& hand, const NodeParameter& parameter) {
  std::string name = parameter.name;
  std::replace(name.begin(), name.end(), '_', '-');
  for (const ConfigField& field : config_fields()) {
    if (field.name != name || !is_field(field, hand.name.empty())) continue;
    set_from_text(field, hand.live, parameter.value);
    return true;
  }
  return false;
}

std::string frame_name(const std::string& text) {
  if (text.empty() || text.front() == '/' ||
      std::any_of(text.begin(), text.end(), [](unsigned char c) { return c <= ' '; }))
    throw BadValue("'" + printable(text) +
                   "' is not a tf frame name: it must not be empty, begin with a slash or contain spaces");
  return text;
}

int decimation_of(const std::string& text) {
  const double number = parse_number(text);
  if (!(number >= 1.0 && number <= kMostDecimation) || number != static_cast<int>(number))
    throw BadValue(printable(text) + " is not a whole number of 1 or more");
  return static_cast<int>(number);
}

std::string folder_of(const std::string& text) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(text, ignored))
    throw BadValue("'" + printable(text) + "' is not a folder; create it first");
  return text;
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::stringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

bool is_true(const std::string& text) {
  if (text != "true" && text != "false")
    throw BadValue("'" + printable(text) + "' is neither true nor false");
  return text == "true";
}

/// \returns false if a hand has no parameter of that name.
bool set_hand(NodeHand& hand, const NodeParameter& parameter) {
  const auto& [name, value] = parameter;
  if (name == "device_frame") {
    hand.device_frame = value.empty() ? value : frame_name(value);
    return true;
  }
  return name == kDevice || set_field(hand, parameter);
}

/// Sets a parameter of the node or of its first hand. \returns false if there is no such parameter.
bool set_node(NodeSettings& settings, const NodeParameter& parameter) {
  const auto& [name, value] = parameter;
  NodeHand& first = settings.hands.front();
  if (name == "scene") {
    first.live.scene.path = value;
  } else if (name == "cloud_decimation") {
    settings.decimation = decimation_of(value);
  } else if (name == "world_frame") {
    settings.world_frame = frame_name(value);
  } else if (name == "tf_prefix") {
    settings.tf_prefix = value.empty() ? value : frame_name(value);
  } else if (name == "scenes") {
    settings.scenes = split(value);
  } else if (name == "recordings") {
    if (!value.empty()) settings.recordings = folder_of(value);
  } else if (name == "hands_touch") {
    settings.hands_touch = is_true(value);
  } else if (name != kConfig && name != kHands) {
    return set_hand(first, parameter);
  }
  return true;
}

/// Calls `set` for each parameter. \throws Error that names the parameter
template <class Set>
void set_each(const std::string& before, const std::vector<NodeParameter>& parameters, const Set& set) {
  for (const NodeParameter& parameter : parameters) {
    const std::string name = printable(before + parameter.name);
    try {
      if (!set(parameter)) throw Error("there is no parameter '{}'; docs/ros.md lists them", name);
    } catch (const BadValue& error) {
      throw Error("parameter '{}': {}", name, error.what());
    }
  }
}

/// Device of the `device` parameter; else `driver`, from the file, if it is of this kind; else `otherwise`.
CrtkArguments device_of(const std::string& kind, const std::vector<NodeParameter>& parameters,
                        const std::string& driver, const std::string& otherwise) {
  const auto parameter = find(parameters, kDevice);
  const bool in_file = driver.starts_with(kind + ":");
  return parse_crtk_arguments(kind, parameter ? *parameter
                                    : in_file ? driver.substr(kind.size() + 1)
                                              : otherwise);
}

void add_hands(NodeSettings& settings, const std::string& kind,
               const std::vector<NodeParameter>& parameters) {
  const LiveConfig first = settings.hands.front().live;
  for (HandSetup& setup :
       read_hands(split(find(parameters, kHands).value_or("")), first, "parameter 'hands'")) {
    const std::vector<NodeParameter> own = parameters_of(setup.name, parameters);
    // Without a file, the configuration is a copy of the first hand's, whose driver must not be used twice.
    const std::string& driver = setup.config.device.driver;
    NodeHand& hand = settings.hands.emplace_back(
        NodeHand{setup.name, setup.config,
                 device_of(kind, own, driver == first.device.driver ? "" : driver, "/" + setup.name)});
    set_each(hand.name + "/", own, [&](const NodeParameter& parameter) { return set_hand(hand, parameter); });
  }
}

/// \throws Error if two hands have the same device.
void check_devices(const std::vector<NodeHand>& hands) {
  std::map<std::string, std::string> names;
  for (const NodeHand& hand : hands) {
    const auto [at, is_new] = names.emplace(hand.device.prefix, hand.name);
    if (!is_new)
      throw Error("parameter '{}/device': {} is the device of another hand", hand.name, hand.device.prefix);
  }
}

}  // namespace

NodeSettings read_node_settings(const std::string& kind, std::vector<NodeParameter> parameters) {
  for (NodeParameter& parameter : parameters)
    std::replace(parameter.name.begin(), parameter.name.end(), '.', '/');
  const auto config = find(parameters, kConfig);
  NodeSettings settings;
  LiveConfig live = config ? read_live_config(*config) : LiveConfig();
  CrtkArguments device = device_of(kind, parameters, live.device.driver, "/omni");
  settings.hands.push_back({.name = {}, .live = std::move(live), .device = std::move(device)});
  std::vector<NodeParameter> of_node, of_hands;
  for (const NodeParameter& parameter : parameters)
    (parameter.name.find('/') == std::string::npos ? of_node : of_hands).push_back(parameter);
  set_each("", of_node, [&](const NodeParameter& parameter) { return set_node(settings, parameter); });
  add_hands(settings, kind, parameters);
  for (const auto& [name, value] : of_hands) {
    const std::string hand = name.substr(0, name.find('/'));
    if (std::none_of(settings.hands.begin(), settings.hands.end(),
                     [&](const NodeHand& known) { return known.name == hand; }))
      throw Error("parameter '{}': there is no hand '{}' in 'hands'", printable(name), printable(hand));
  }
  check_devices(settings.hands);
  for (NodeHand& hand : settings.hands)
    if (hand.device_frame.empty())
      hand.device_frame = settings.tf_prefix + (hand.name.empty() ? "" : hand.name + "/") + "device";
  return settings;
}

}  // namespace palpate::node

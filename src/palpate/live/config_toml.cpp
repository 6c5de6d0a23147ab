#include <palpate/live/config_toml.h>

#include <algorithm>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <palpate/base/error.h>
#include <palpate/base/toml_file.h>
#include <palpate/haptics/tool_file.h>
#include <palpate/live/config_fields.h>
#include <palpate/live/value_text.h>

namespace palpate {
namespace {

constexpr const char* kScenePath = "scene";

std::string array_of(const std::vector<double>& all) { return fmt::format("[{}]", fmt::join(all, ", ")); }

/// Returns the value of a field as TOML; nothing if it is not set.
struct TomlText {
  using Text = std::optional<std::string>;
  const LiveConfig& config;

  Text operator()(const FlagField& field) const { return field.member(config) ? Text("true") : std::nullopt; }
  Text operator()(const TextField& field) const {
    const std::string& text = field.member(config);
    return text.empty() ? std::nullopt : Text(toml_quoted(text));
  }
  Text operator()(const CountField& field) const {
    const int count = field.member(config);
    return count < field.least ? std::nullopt : Text(fmt::format("{}", count));
  }
  Text operator()(const NumberField& field) const { return fmt::format("{}", field.member(config)); }
  Text operator()(const OptionalField& field) const {
    const std::optional<double>& number = field.member(config);
    return number ? Text(fmt::format("{}", *number)) : std::nullopt;
  }
  Text operator()(const ChoiceField& field) const { return toml_quoted(field.chosen(config)); }
  Text operator()(const NumbersField& field) const {
    const std::vector<double> all = field.get(config);
    return all.empty() ? std::nullopt : Text(array_of(all));
  }
  Text operator()(const ToolField& field) const {
    const Tool& tool = field.member(config);
    const ToolPart& part = tool.parts()[0];
    const bool one = tool.parts().size() == 1 && part.pose.position.isZero(0.0) &&
                     part.pose.orientation.isApprox(Eigen::Quaterniond::Identity(), 0.0);
    const Eigen::Vector3d& a = part.semi_axes;
    // Literal string; TOML drops its first line break.
    return one ? array_of({a.x(), a.y(), a.z()}) : fmt::format("'''\n{}'''", tool_text(tool));
  }
};

/// Returns whether another field is set that replaces this one.
bool is_replaced(const ConfigField& field, const LiveConfig& config) {
  const auto fields = config_fields();
  return std::any_of(fields.begin(), fields.end(), [&](const ConfigField& other) {
    return !field.name.empty() && other.traits.excludes == field.name &&
           std::visit(TomlText{config}, other.type).has_value();
  });
}

constexpr const char* kLeftOut =
    "# Left out: the scene's file, --no-index-file, the options of the gateway, --hands, --hands-touch,\n"
    "# --record, --scenes and --seconds, and the place of a headset's room.\n";

/// Returns the value of a field that has a name; nothing if it is not set or another field replaces it.
std::optional<std::string> value_of(const ConfigField& field, const LiveConfig& config) {
  if (field.name.empty() || is_replaced(field, config)) return std::nullopt;
  return std::visit(TomlText{config}, field.type);
}

/// Returns whether a file with `fields` has this field, if it is set.
bool is_written(const ConfigField& field, const LiveConfig& config, TomlFields fields) {
  using enum ConfigGroup;
  if (fields == TomlFields::kAll) return true;
  if (fields == TomlFields::kSavedOfHand && field.group == kScene) return false;
  if (field.traits.saved) return true;
  const bool of_run = field.group == kScene || field.group == kGateway;
  return !of_run && value_of(field, config) != value_of(field, {});
}

}  // namespace

std::string to_toml(const LiveConfig& config, TomlFields fields) {
  std::string text = "# For palpate --config.\n";
  if (fields != TomlFields::kAll) text += kLeftOut;
  if (fields == TomlFields::kAll && !config.scene.path.empty())
    text += fmt::format("{} = {}\n", kScenePath, toml_quoted(config.scene.path));
  for (const ConfigField& field : config_fields()) {
    if (!is_written(field, config, fields)) continue;
    if (const auto value = value_of(field, config)) text += fmt::format("{} = {}\n", field.name, *value);
  }
  return text;
}

std::vector<SettingText> settings_text(const LiveConfig& config, ConfigGroup group) {
  std::vector<SettingText> all;
  if (group == ConfigGroup::kScene && !config.scene.path.empty())
    all.push_back({kScenePath, toml_quoted(config.scene.path)});
  for (const ConfigField& field : config_fields()) {
    if (field.group != group) continue;
    if (const auto value = value_of(field, config)) all.push_back({std::string(field.name), *value});
  }
  return all;
}

std::string toml_quoted(std::string_view text) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  std::string out = "\"";
  while (!text.empty()) {
    const auto control = std::find_if(text.begin(), text.end(), is_control);
    const auto plain = static_cast<std::size_t>(control - text.begin());
    for (const char c : printable(text.substr(0, plain))) {
      if (c == '"' || c == '\\') out += '\\';
      out += c;
    }
    if (plain == text.size()) break;
    out += fmt::format("\\u{:04x}", static_cast<unsigned char>(text[plain]));
    text.remove_prefix(plain + 1);
  }
  return out + '"';
}

std::string value_text(const TomlValue& value) {
  std::vector<std::string> parts;
  for (const TomlValue& item : value.is_array() ? value.items() : std::vector{value}) {
    const auto text = item.scalar();
    if (!text) throw value.must_be("a number, text, true, false or an array of these");
    parts.push_back(*text);
  }
  return fmt::format("{}", fmt::join(parts, ","));
}

std::vector<ConfigEntry> read_config(const std::string& path) {
  const TomlFile file(path);
  std::vector<ConfigEntry> entries;
  for (const TomlValue& value : file.root().values())
    entries.push_back({std::string(value.key()), value_text(value), path, value.line()});
  return entries;
}

LiveConfig read_live_config(const std::string& path, LiveConfig config, bool (*is_refused)(ConfigGroup)) {
  const TomlFile file(path);
  TomlTable root = file.root();
  const auto admit = [&](const TomlValue& value, ConfigGroup group) {
    if (is_refused != nullptr && is_refused(group))
      throw Error("{}: line {}: '{}' applies to all hands; set it for the first hand only", path,
                  value.line(), value.key());
  };
  if (const auto scene = root.find(kScenePath)) {
    admit(*scene, ConfigGroup::kScene);
    config.scene.path = scene->text();
  }
  for (const ConfigField& field : config_fields()) {
    if (field.name.empty()) continue;
    const auto value = root.find(field.name);
    if (!value) continue;
    admit(*value, field.group);
    try {
      set_from_text(field, config, value_text(*value));
    } catch (const BadValue& error) {
      throw Error("{}: line {}: '{}': {}", path, value->line(), field.name, error.what());
    }
    if (!field.traits.excludes.empty() && root.find(field.traits.excludes)) {
      throw Error("{}: line {}: '{}' cannot go with '{}'; keep one of them", path, value->line(), field.name,
                  field.traits.excludes);
    }
  }
  root.refuse_others();
  return config;
}

}  // namespace palpate

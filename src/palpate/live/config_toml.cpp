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

/// As a basic string.
std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
    else
      out += c;
  }
  return out + '"';
}

std::string array_of(const std::vector<double>& all) { return fmt::format("[{}]", fmt::join(all, ", ")); }

/// The value of a field; nothing if it is not set.
struct TomlText {
  using Text = std::optional<std::string>;
  const LiveConfig& config;

  Text operator()(const FlagField& field) const { return field.member(config) ? Text("true") : std::nullopt; }
  Text operator()(const TextField& field) const {
    const std::string& text = field.member(config);
    return text.empty() ? std::nullopt : Text(quoted(text));
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
  Text operator()(const ChoiceField& field) const { return quoted(field.chosen(config)); }
  Text operator()(const NumbersField& field) const {
    const std::vector<double> all = field.get(config);
    return all.empty() ? std::nullopt : Text(array_of(all));
  }
  Text operator()(const ToolField& field) const {
    const Tool& tool = field.member(config);
    const ToolPart& part = tool.parts()[0];
    const bool one = tool.parts().size() == 1 && part.pose.position.isZero(0.0) &&
                     part.pose.orientation.isApprox(Eigen::Quaterniond::Identity());
    const Eigen::Vector3d& a = part.semi_axes;
    // A literal string, whose first line break is no part of it.
    return one ? array_of({a.x(), a.y(), a.z()}) : fmt::format("'''\n{}'''", tool_text(tool));
  }
};

/// True if another field is set that replaces this one.
bool is_replaced(const ConfigField& field, const LiveConfig& config) {
  const auto fields = config_fields();
  return std::any_of(fields.begin(), fields.end(), [&](const ConfigField& other) {
    return !field.name.empty() && other.traits.excludes == field.name &&
           std::visit(TomlText{config}, other.type).has_value();
  });
}

/// A scalar as it is, an array's values joined by commas.
std::string text_of(const TomlValue& value) {
  std::vector<std::string> parts;
  for (const TomlValue& item : value.is_array() ? value.items() : std::vector{value}) {
    const auto text = item.scalar();
    if (!text) throw value.must_be("a number, text, true, false or an array of these");
    parts.push_back(*text);
  }
  return fmt::format("{}", fmt::join(parts, ","));
}

}  // namespace

std::string to_toml(const LiveConfig& config, TomlFields fields) {
  std::string text = "# For palpate --config.\n";
  if (fields == TomlFields::kAll && !config.scene.path.empty())
    text += fmt::format("{} = {}\n", kScenePath, quoted(config.scene.path));
  for (const ConfigField& field : config_fields()) {
    if (field.name.empty() || (fields == TomlFields::kSaved && !field.traits.saved)) continue;
    if (is_replaced(field, config)) continue;
    if (const auto value = std::visit(TomlText{config}, field.type))
      text += fmt::format("{} = {}\n", field.name, *value);
  }
  return text;
}

LiveConfig read_live_config(const std::string& path, LiveConfig config) {
  const TomlFile file(path);
  TomlTable root = file.root();
  if (const auto scene = root.find(kScenePath)) config.scene.path = scene->text();
  for (const ConfigField& field : config_fields()) {
    if (field.name.empty()) continue;
    const auto value = root.find(field.name);
    if (!value) continue;
    try {
      set_from_text(field, config, text_of(*value));
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

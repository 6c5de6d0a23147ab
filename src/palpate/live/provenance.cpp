#include <palpate/live/provenance.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <palpate/base/version.h>
#include <palpate/collision/index_file.h>
#include <palpate/collision/open_index.h>
#include <palpate/study/machine.h>

namespace palpate {
namespace {

std::string checksum_text(std::uint64_t hash) { return fmt::format("xxh3-16MiB:{:016x}", hash); }

std::string table(std::string_view name, const std::vector<SettingText>& items) {
  std::string text = fmt::format("[{}]\n", name);
  for (const SettingText& item : items) text += fmt::format("{} = {}\n", item.name, item.value);
  return text;
}

/// Returns `text` unchanged if TOML also reads it as a number, true or false; otherwise as a TOML string.
std::string toml_value(const std::string& text) {
  if (!nlohmann::json::accept(text)) return toml_quoted(text);
  const nlohmann::json value = nlohmann::json::parse(text);
  const bool too_large = value.is_number_unsigned() &&
                         value.get<std::uint64_t>() > std::uint64_t{std::numeric_limits<std::int64_t>::max()};
  return value.is_boolean() || (value.is_number() && !too_large) ? text : toml_quoted(text);
}

}  // namespace

SceneOrigin scene_origin(const SceneConfig& scene) {
  return {std::filesystem::path(scene.name()).filename().string(),
          scene.path.empty() ? std::string() : checksum_text(scene_hash(scene.path))};
}

Provenance provenance(std::string_view command, const SceneOrigin& scene, const LiveConfig& config,
                      std::initializer_list<ConfigGroup> groups) {
  Provenance known;
  const auto tell = [&](const char* name, std::string_view text) {
    if (!text.empty()) known.made.push_back({name, toml_quoted(text)});
  };
  tell("version", version());
  tell("command", command);
  tell("scene", scene.name);
  tell("scene-checksum", scene.checksum);
  if (!config.force.materials.empty()) tell("materials-checksum", file_checksum(config.force.materials));
  tell("machine", machine());
  for (const ConfigGroup group : groups) {
    for (SettingText& setting : settings_text(config, group)) known.settings.push_back(std::move(setting));
  }
  return known;
}

void set(Provenance& provenance, std::string_view name, const std::string& value) {
  std::vector<SettingText>& all = provenance.settings;
  const auto at = std::find_if(all.begin(), all.end(), [&](const SettingText& s) { return s.name == name; });
  if (at != all.end()) {
    at->value = value;
  } else {
    all.push_back({std::string(name), value});
  }
}

void set_text(Provenance& provenance, std::string_view name, const std::string& text) {
  set(provenance, name, toml_value(text));
}

std::string to_toml(const Provenance& provenance) {
  return table("made", provenance.made) + table("settings", provenance.settings);
}

std::string file_checksum(const std::string& path) { return checksum_text(content_hash(path)); }

}  // namespace palpate

#include <palpate/live/provenance.h>

#include <cstdint>
#include <filesystem>

#include <fmt/format.h>

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

std::string to_toml(const Provenance& provenance) {
  return table("made", provenance.made) + table("settings", provenance.settings);
}

std::string file_checksum(const std::string& path) { return checksum_text(content_hash(path)); }

}  // namespace palpate

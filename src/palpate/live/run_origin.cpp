#include <palpate/live/run_origin.h>

#include <filesystem>
#include <string_view>

#include <palpate/base/csv.h>
#include <palpate/base/error.h>
#include <palpate/base/toml_file.h>
#include <palpate/live/provenance.h>

namespace palpate {
namespace {

/// Setting of a live loop that is replaced by the run itself: the recorded hand deviated from it.
constexpr std::string_view kTrajectoryKey = "trajectory";
constexpr std::string_view kSceneKey = "scene";

std::string text_at(TomlTable& table, std::string_view key) {
  const auto value = table.find(key);
  return value ? value->text() : std::string();
}

}  // namespace

bool has_provenance(const std::string& run) { return !CsvReader(run).header().comment.empty(); }

RunOrigin::RunOrigin(const std::string& run) : run_(run) {
  const std::string head = CsvReader(run).header().comment;
  if (head.empty())
    throw Error("{}: has no record of how it was made; give its scene and options, and --trajectory {}", run,
                run);
  const TomlFile file(run, head);
  TomlTable root = file.root();
  TomlTable made = root.at("made").table();
  version_ = text_at(made, "version");
  scene_checksum_ = text_at(made, "scene-checksum");
  materials_checksum_ = text_at(made, "materials-checksum");
  for (const TomlValue& value : root.at("settings").table().values()) {
    if (value.key() == kSceneKey) {
      scene_ = value.text();
    } else if (value.key() != kTrajectoryKey) {
      settings_.push_back({std::string(value.key()), value_text(value), run, value.line()});
    }
  }
}

std::vector<ConfigEntry> RunOrigin::entries() const {
  std::vector<ConfigEntry> all = settings_;
  all.push_back({std::string(kTrajectoryKey), run_, run_, 1});
  return all;
}

void RunOrigin::check(const SceneConfig& scene) const {
  if (scene_checksum_.empty()) return;
  const std::string checksum = scene_origin(scene).checksum;
  if (checksum == scene_checksum_) return;
  throw Error("{}: was made with another scene than {} ({}, not {}); give that one, or omit --scene", run_,
              scene.name(), scene_checksum_, checksum);
}

void RunOrigin::settle(LiveConfig& live) const {
  std::string& scene = live.scene.path;
  const bool found = !scene.empty();
  if (scene.empty()) scene = scene_;
  std::error_code ignored;
  if (!found && !scene.empty() && !std::filesystem::exists(scene, ignored))
    throw Error("{}: scene {} not found; if it has moved: palpate replay SCENE --from {}", run_, scene, run_);
  const std::string checksum = scene_origin(live.scene).checksum;
  if (checksum != scene_checksum_) {
    throw Error(
        "{}: was made with another scene than {} ({}, not {}); give that one, or replay --trajectory {}",
        run_, live.scene.name(), scene_checksum_.empty() ? "built in" : scene_checksum_, checksum, run_);
  }
  const std::string& materials = live.force.materials;
  if (!materials.empty() && file_checksum(materials) != materials_checksum_)
    throw Error("{}: was made with other materials than {}; give those with --materials FILE", run_,
                materials);
}

}  // namespace palpate

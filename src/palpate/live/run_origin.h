/// \file
/// Provenance read back from a run's file, to repeat the run or to check that a scene is the one it was made
/// with.
#pragma once

#include <string>
#include <vector>

#include <palpate/live/config_toml.h>
#include <palpate/live/live_config.h>

namespace palpate {

/// Returns whether a run's file has a provenance header. \throws Error if it cannot be read.
bool has_provenance(const std::string& run);

/// Provenance header of a run's file, as written by to_toml(const Provenance&).
class RunOrigin {
 public:
  /// \throws Error if the file cannot be read or has no provenance header.
  explicit RunOrigin(const std::string& run);

  /// All settings but the scene, with the run itself as trajectory.
  std::vector<ConfigEntry> entries() const;

  /// Sets the run's scene if `live` has none, and compares checksums. \throws Error if the scene file does
  /// not exist, or if the scene or the materials of `live` are not those of the run; the message is one line
  /// that says what to do.
  void settle(LiveConfig& live) const;

  /// Compares the checksum of `scene` with the run's, if it has one. \throws Error if they differ, a line
  /// that says what to do.
  void check(const SceneConfig& scene) const;

  /// Version of the program that made the run.
  const std::string& version() const { return version_; }

 private:
  std::string run_, version_, scene_, scene_checksum_, materials_checksum_;
  std::vector<ConfigEntry> settings_;
};

}  // namespace palpate

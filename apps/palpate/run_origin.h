/// \file
/// Provenance read from a run's file, for `palpate replay --from RUN` and `palpate report RUN --scene SCENE`.
#pragma once

#include <string>
#include <vector>

#include <palpate/live/live_config.h>

#include "config.h"

namespace palpate::cli {

/// Returns whether a run's file has a provenance header. \throws Error if it cannot be read.
bool says_how_it_was_made(const std::string& run);

/// Content of the header of a run's file (to_toml(const Provenance&)).
class RunOrigin {
 public:
  /// \throws Error if the file cannot be read, or does not say it.
  explicit RunOrigin(const std::string& run);

  /// The settings but for the scene, and the run itself as trajectory.
  std::vector<ConfigEntry> entries() const;

  /// Takes the run's scene where `live` has none. \throws Error if that is not there, or if the scene or the
  /// materials of `live` are not those that the run was made with: one line with what to do.
  void settle(LiveConfig& live) const;

  /// Of the program that made it.
  const std::string& version() const { return version_; }

 private:
  std::string run_, version_, scene_, scene_checksum_, materials_checksum_;
  std::vector<ConfigEntry> settings_;
};

}  // namespace palpate::cli

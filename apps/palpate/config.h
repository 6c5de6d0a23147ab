/// \file
/// Options from a TOML file.
#pragma once

#include <string>
#include <vector>

#include <palpate/live/config_toml.h>

#include "declare.h"

namespace palpate::cli {

/// The subcommand called `name`; null if there is none.
const CLI::App* find_command(const CLI::App& app, const std::string& name);

/// Option of `replay` that names a run: its settings are the defaults and its poses the trajectory.
inline constexpr const char* kFromRun = "--from";

/// Command line completed from files.
struct Arguments {
  std::vector<std::string> all;
  std::vector<ConfigEntry> from_files;  ///< the entries added
};

/// Adds to `arguments` (without the program name) the entries of its --config FILE, then the settings of the
/// run of `replay --from RUN` or of the first run of `report RUN --scene SCENE` (see run_origin.h). Only
/// entries that the command has an option for, that the arguments neither set nor exclude, and that need no
/// option that is not given are added. `scene` is the argument SCENE where the command has one.
/// \throws Error for a broken file, a key that is no option of any command, or two that exclude each other.
Arguments with_config(const CLI::App& app, const std::vector<std::string>& arguments);

}  // namespace palpate::cli

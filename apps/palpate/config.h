/// \file
/// Options from a TOML file.
#pragma once

#include <string>
#include <vector>

#include "declare.h"

namespace palpate::cli {

/// The subcommand called `name`; null if there is none.
const CLI::App* find_command(const CLI::App& app, const std::string& name);

/// A key of a configuration file, as the command line would have it.
struct ConfigEntry {
  std::string key;    ///< long option name without dashes
  std::string value;  ///< text of the value; arrays joined by commas
  std::string file;   ///< where it is, for messages
  std::size_t line;
};

/// Reads a TOML file whose keys are long option names (`opacity-min = 0.2`, `tool = [0.01, 0.01,
/// 0.03]`, `json = true`). A flag that is false is left out.
/// \throws Error with file and line if the file is not TOML or a value has no place on a command
/// line (tables, dates).
std::vector<ConfigEntry> read_config(const std::string& path);

/// The option of `replay` that names a run whose settings are the defaults, and its poses the trajectory.
inline constexpr const char* kFromRun = "--from";

/// `arguments` (without the program name) plus what its --config FILE adds, and then the settings of the run
/// of `replay --from RUN`, and of the first of `report RUN --scene SCENE` (see run_origin.h): entries that
/// the command has an option for and that the arguments neither set nor exclude. \throws Error for a broken
/// file, a key that is no option of any command, or two that exclude each other.
struct Arguments {
  std::vector<std::string> all;
  std::vector<ConfigEntry> from_files;  ///< what was added
};
Arguments with_config(const CLI::App& app, const std::vector<std::string>& arguments);

}  // namespace palpate::cli

/// \file
/// Declaration of commands and options. Wraps CLI11, whose headers take longer to compile than all commands
/// together: only code that inspects its option tree includes them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <palpate/geometry/pose.h>
#include <palpate/live/value_text.h>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace palpate::cli {

/// A declared option, for setting further properties.
class DeclaredOption {
 public:
  explicit DeclaredOption(CLI::Option* option) : option_(option) {}

  DeclaredOption& required();
  DeclaredOption& in_group(const std::string& group);      ///< heading in --help
  DeclaredOption& shows_default(const std::string& text);  ///< in --help
  DeclaredOption& excludes(const DeclaredOption& other);

 private:
  CLI::Option* option_;  ///< owned by the command, which outlives this
};

/// \name Declarations
/// `name` is "--name" or, for a positional argument, "NAME". `type` is the placeholder of the value in --help
/// (empty: CLI11's own). The initial `value` is the default; choices, lists and numbers show it in --help.
/// `value` must live until the arguments are parsed.
/// @{
CLI::App& add_command(CLI::App& parent, const std::string& name, const std::string& description);

/// Adds a command that --help does not list.
CLI::App& add_hidden_command(CLI::App& parent, const std::string& name, const std::string& description);
DeclaredOption add_flag(CLI::App& app, const std::string& name, bool& value, const std::string& description);

DeclaredOption add_text(CLI::App& app, const std::string& name, std::string& value, const std::string& type,
                        const std::string& description);

DeclaredOption add_choice(CLI::App& app, const std::string& name, std::string& value,
                          const std::vector<std::string>& choices, const std::string& description);

/// The same, with the choice passed to `set`.
DeclaredOption add_choice(CLI::App& app, const std::string& name, const std::vector<std::string>& choices,
                          const std::string& description, const std::function<void(const std::string&)>& set);

/// Several choices, separated by commas.
DeclaredOption add_choices(CLI::App& app, const std::string& name, std::vector<std::string>& values,
                           const std::vector<std::string>& choices, const std::string& description);

/// Several files, as separate arguments.
DeclaredOption add_files(CLI::App& app, const std::string& name, std::vector<std::string>& values,
                         const std::string& description);

/// Several texts, separated by commas.
DeclaredOption add_texts(CLI::App& app, const std::string& name, std::vector<std::string>& values,
                         const std::string& type, const std::string& description);

/// Requires all `options`, unless `instead` is given. Once per command.
void need_unless(CLI::App& app, const std::vector<std::string>& options, const std::string& instead);

/// Requires `needed` where one of `options` is given. Entries of a configuration file are ignored instead.
void need(CLI::App& app, const std::vector<std::string>& options, const std::string& needed);

/// Permits none of `options` beside `other`.
void exclude(CLI::App& app, const std::vector<std::string>& options, const std::string& other);

std::string command_name(const CLI::App& app);

/// Returns the options that affect results but are not fields of a LiveConfig: long name without dashes, and
/// the text of the given value or the default.
std::vector<std::pair<std::string, std::string>> other_options(const CLI::App& app);

/// Returns whether the option was given on the command line or in its configuration file.
bool is_given(const CLI::App& app, const std::string& option);

/// A whole number from `low` to `high`. A default out of that range means "not given", and is not shown.
DeclaredOption add_count(CLI::App& app, const std::string& name, int& value, int low, int high,
                         const std::string& description);

/// A number in [low, high], not NaN, in `unit`.
DeclaredOption add_number(CLI::App& app, const std::string& name, double& value, double low, double high,
                          const std::string& unit, const std::string& description);

/// Several numbers in [low, high], separated by commas.
DeclaredOption add_numbers(CLI::App& app, const std::string& name, std::vector<double>& values, double low,
                           double high, const std::string& description);

/// --seed, a whole number.
DeclaredOption add_seed(CLI::App& app, std::uint64_t& seed, const std::string& description);

/// Exactly three numbers, in `unit`.
DeclaredOption add_vector3(CLI::App& app, const std::string& name, Eigen::Vector3d& value,
                           const std::string& unit, const std::string& description);

/// Adds an option whose text is parsed by `set`, which throws BadValue to reject it.
DeclaredOption add_parsed(CLI::App& app, const std::string& name, const std::string& type,
                          const std::string& description, const std::function<void(const std::string&)>& set);
/// @}

/// "x,y,z" or "x,y,z,qw,qx,qy,qz". \throws BadValue.
Pose parse_pose(const std::string& text);

}  // namespace palpate::cli

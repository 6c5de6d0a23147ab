#include "config.h"

#include <algorithm>

#include <CLI/CLI.hpp>

#include <palpate/base/error.h>
#include <palpate/live/run_origin.h>

namespace palpate::cli {
namespace {

constexpr const char* kSceneKey = "scene";  // an option of some commands, an argument of others

/// Returns whether `arguments` give option `name` ("--name", "--name=value").
bool gives(const std::vector<std::string>& arguments, const std::string& name) {
  return std::any_of(arguments.begin(), arguments.end(), [&](const std::string& argument) {
    return argument == name || argument.starts_with(name + "=");
  });
}

/// Value of option `name`; empty if it is not given.
std::string value_given(const std::vector<std::string>& arguments, const std::string& name) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i].starts_with(name + "=")) return arguments[i].substr(name.size() + 1);
    if (arguments[i] == name && i + 1 < arguments.size()) return arguments[i + 1];
  }
  return {};
}

/// First argument that is neither an option nor the value of one.
std::string first_positional(const CLI::App& command, const std::vector<std::string>& arguments) {
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (!argument.starts_with("-")) return argument;
    const CLI::Option* option = command.get_option_no_throw(argument);
    if (option != nullptr && option->get_expected_max() > 0) ++i;
  }
  return {};
}

/// Path of the run whose settings are the defaults; empty if there is none.
std::string run_taken_from(const CLI::App& command, const std::vector<std::string>& arguments) {
  if (command.get_name() == "replay") return value_given(arguments, kFromRun);
  if (command.get_name() != "report" || !gives(arguments, "--scene")) return {};
  const std::string run = first_positional(command, arguments);
  return !run.empty() && has_provenance(run) ? run : std::string();
}

const CLI::Option* find_option(const CLI::App& app, const std::string& name) {
  return app.get_option_no_throw(name);
}

/// Returns whether the scene is an argument of `command` rather than an option.
bool takes_scene(const CLI::App& command) { return find_option(command, "SCENE") != nullptr; }

bool known_anywhere(const CLI::App& app, const std::string& name) {
  const auto subcommands = app.get_subcommands([](const CLI::App*) { return true; });
  return std::any_of(subcommands.begin(), subcommands.end(),
                     [&](const CLI::App* sub) { return find_option(*sub, name) != nullptr; });
}

/// Returns whether `arguments` give an option that excludes `option`, or that it excludes.
bool excluded(const CLI::App& command, const CLI::Option& option, const std::vector<std::string>& arguments) {
  const auto excludes = [](const CLI::Option& a, const CLI::Option& b) {
    const auto others = a.get_excludes();
    return std::any_of(others.begin(), others.end(), [&](const CLI::Option* other) { return other == &b; });
  };
  const auto options = command.get_options();
  return std::any_of(options.begin(), options.end(), [&](const CLI::Option* other) {
    return (excludes(option, *other) || excludes(*other, option)) && gives(arguments, other->get_name());
  });
}

/// Returns whether `option` needs one that neither `arguments` nor `entries` give.
bool lacks_needed(const CLI::App& command, const CLI::Option& option,
                  const std::vector<std::string>& arguments, const std::vector<ConfigEntry>& entries) {
  const auto needed = option.get_needs();
  return std::any_of(needed.begin(), needed.end(), [&](const CLI::Option* one) {
    const auto gives_it = [&](const ConfigEntry& entry) { return "--" + entry.key == one->get_name(); };
    const bool in_file =
        std::any_of(entries.begin(), entries.end(), gives_it) && !excluded(command, *one, arguments);
    return !in_file && !gives(arguments, one->get_name());
  });
}

/// Appends the entries that `command` has an option for and that the given arguments neither set nor exclude,
/// and that have what they need: one file may serve several commands. A flag that is false is omitted.
void add(Arguments& arguments, const CLI::App& app, const CLI::App& command,
         const std::vector<ConfigEntry>& entries) {
  const std::vector<std::string> given = arguments.all;
  std::vector<ConfigEntry> added;
  for (const ConfigEntry& entry : entries) {
    const std::string name = "--" + entry.key;
    if (!known_anywhere(app, name) || name == "--config" || name == "--help") {
      throw Error("{}: line {}: '{}' is not an option of any command; see palpate --help", entry.file,
                  entry.line, entry.key);
    }
    if (entry.key == kSceneKey && takes_scene(command)) {
      if (!first_positional(command, given).empty()) continue;
      arguments.all.push_back(entry.value);
      added.push_back(entry);
      continue;
    }
    const CLI::Option* option = find_option(command, name);
    if (option == nullptr || gives(given, name) || excluded(command, *option, given) ||
        lacks_needed(command, *option, given, entries))
      continue;
    const bool flag = option->get_expected_max() == 0;
    if (flag && entry.value != "true" && entry.value != "false") {
      throw Error("{}: line {}: '{}' must be true or false", entry.file, entry.line, entry.key);
    }
    if (flag && entry.value == "false") continue;
    arguments.all.push_back(flag ? name : name + "=" + entry.value);
    for (const ConfigEntry& other : added) {
      if (excluded(command, *option, {"--" + other.key})) {
        throw Error("{}: line {}: '{}' cannot go with '{}'; keep one of them", entry.file, entry.line,
                    entry.key, other.key);
      }
    }
    added.push_back(entry);
  }
  arguments.from_files.insert(arguments.from_files.end(), added.begin(), added.end());
}

}  // namespace

const CLI::App* find_command(const CLI::App& app, const std::string& name) {
  const auto found = app.get_subcommands([&](const CLI::App* sub) { return sub->get_name() == name; });
  return found.empty() ? nullptr : found.front();
}

Arguments with_config(const CLI::App& app, const std::vector<std::string>& arguments) {
  Arguments result{arguments, {}};
  const CLI::App* command = arguments.empty() ? nullptr : find_command(app, arguments.front());
  if (command == nullptr) return result;
  if (const std::string path = value_given(arguments, "--config"); !path.empty())
    add(result, app, *command, read_config(path));
  if (const std::string run = run_taken_from(*command, result.all); !run.empty())
    add(result, app, *command, RunOrigin(run).entries());
  return result;
}

}  // namespace palpate::cli

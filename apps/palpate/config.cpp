#include "config.h"

#include <algorithm>
#include <optional>

#include <CLI/CLI.hpp>

#include <palpate/base/error.h>
#include <palpate/base/toml_file.h>

namespace palpate::cli {
namespace {

/// A scalar as it is, an array's joined by commas; nothing for other values.
std::optional<std::string> value_text(const TomlValue& value) {
  if (!value.is_array()) return value.scalar();
  std::string joined;
  for (const TomlValue& item : value.items()) {
    const auto text = item.scalar();
    if (!text) return std::nullopt;
    joined += (joined.empty() ? "" : ",") + *text;
  }
  return joined;
}

/// True if `arguments` give option `name` ("--name", "--name=value").
bool gives(const std::vector<std::string>& arguments, const std::string& name) {
  return std::any_of(arguments.begin(), arguments.end(), [&](const std::string& argument) {
    return argument == name || argument.starts_with(name + "=");
  });
}

/// The value of --config, if given.
std::string config_path(const std::vector<std::string>& arguments) {
  const std::string name = "--config";
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i].starts_with(name + "=")) return arguments[i].substr(name.size() + 1);
    if (arguments[i] == name && i + 1 < arguments.size()) return arguments[i + 1];
  }
  return {};
}

const CLI::Option* find_option(const CLI::App& app, const std::string& name) {
  return app.get_option_no_throw(name);
}

bool known_anywhere(const CLI::App& app, const std::string& name) {
  const auto subcommands = app.get_subcommands([](const CLI::App*) { return true; });
  return std::any_of(subcommands.begin(), subcommands.end(),
                     [&](const CLI::App* sub) { return find_option(*sub, name) != nullptr; });
}

/// True if `arguments` give an option that `option` cannot go with.
bool excluded(const CLI::Option& option, const std::vector<std::string>& arguments) {
  const auto& others = option.get_excludes();
  return std::any_of(others.begin(), others.end(),
                     [&](const CLI::Option* other) { return gives(arguments, other->get_name()); });
}

}  // namespace

const CLI::App* find_command(const CLI::App& app, const std::string& name) {
  const auto found = app.get_subcommands([&](const CLI::App* sub) { return sub->get_name() == name; });
  return found.empty() ? nullptr : found.front();
}

std::vector<ConfigEntry> read_config(const std::string& path) {
  const TomlFile file(path);
  std::vector<ConfigEntry> entries;
  for (const TomlValue& value : file.root().values()) {
    const auto text = value_text(value);
    if (!text) throw value.must_be("a number, text, true, false or an array of these");
    entries.push_back({std::string(value.key()), *text, value.line()});
  }
  return entries;
}

Arguments with_config(const CLI::App& app, const std::vector<std::string>& arguments) {
  Arguments result{arguments, config_path(arguments), {}};
  if (result.config_path.empty() || arguments.empty()) return result;
  const CLI::App* command = find_command(app, arguments.front());
  if (command == nullptr) return result;
  for (const ConfigEntry& entry : read_config(result.config_path)) {
    const std::string name = "--" + entry.key;
    if (!known_anywhere(app, name) || name == "--config" || name == "--help") {
      throw Error("{}: line {}: '{}' is not an option of any command; see palpate --help", result.config_path,
                  entry.line, entry.key);
    }
    const CLI::Option* option = find_option(*command, name);
    if (option == nullptr || gives(arguments, name) || excluded(*option, arguments)) continue;
    const bool flag = option->get_expected_max() == 0;
    if (flag && entry.value != "true" && entry.value != "false") {
      throw Error("{}: line {}: '{}' must be true or false", result.config_path, entry.line, entry.key);
    }
    if (flag && entry.value == "false") continue;
    result.all.push_back(flag ? name : name + "=" + entry.value);
    for (const ConfigEntry& other : result.from_config) {
      if (excluded(*option, {"--" + other.key})) {
        throw Error("{}: line {}: '{}' cannot go with '{}'; keep one of them", result.config_path, entry.line,
                    entry.key, other.key);
      }
    }
    result.from_config.push_back(entry);
  }
  return result;
}

}  // namespace palpate::cli

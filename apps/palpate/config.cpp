#include "config.h"

#include <algorithm>
#include <optional>
#include <sstream>

#include <fmt/format.h>
#include <toml++/toml.h>
#include <CLI/CLI.hpp>

#include <palpate/base/error.h>
#include <palpate/base/file.h>

namespace palpate::cli {
namespace {

constexpr std::uint64_t kMaxConfigBytes = 1 << 16;

/// The parser descends once for every dot of a key and every bracket, without a limit of its own:
/// more of them in a line than any configuration has would end its stack.
constexpr std::ptrdiff_t kMaxNesting = 100;

void check_nesting(const std::string& path, std::string_view text) {
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::string_view here = text.substr(0, text.find('\n'));
    const auto nesting =
        std::count_if(here.begin(), here.end(), [](char c) { return c == '.' || c == '[' || c == '{'; });
    if (nesting > kMaxNesting)
      throw Error("{}: line {}: is nested too deeply; keys are option names", path, line);
    text.remove_prefix(std::min(here.size() + 1, text.size()));
  }
}

/// The text of a TOML scalar, nothing for other values.
std::optional<std::string> scalar_text(const toml::node& node) {
  if (const auto* v = node.as_string()) return v->get();
  if (const auto* v = node.as_integer()) return fmt::format("{}", v->get());
  if (const auto* v = node.as_floating_point()) return fmt::format("{}", v->get());
  if (const auto* v = node.as_boolean()) return v->get() ? "true" : "false";
  return std::nullopt;
}

std::optional<std::string> value_text(const toml::node& node) {
  const toml::array* array = node.as_array();
  if (array == nullptr) return scalar_text(node);
  std::string joined;
  for (const toml::node& item : *array) {
    const auto text = scalar_text(item);
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
  const std::string text = read_text_file(path, kMaxConfigBytes);
  check_nesting(path, text);
  toml::table table;
  try {
    table = toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw Error("{}: line {}: {}", path, error.source().begin.line, error.description());
  }
  std::vector<ConfigEntry> entries;
  for (const auto& [key, node] : table) {
    const std::size_t line = node.source().begin.line;
    const auto value = value_text(node);
    if (!value)
      throw Error("{}: line {}: '{}' must be a number, text, true, false or an array of these", path, line,
                  key.str());
    entries.push_back({std::string(key.str()), *value, line});
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

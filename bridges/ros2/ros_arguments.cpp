#include "ros_arguments.h"

#include <algorithm>
#include <cctype>
#include <string_view>

#include <palpate/base/error.h>

namespace palpate::ros2 {
namespace {

constexpr std::string_view kUsage = "expected --ros-args -r FROM:=TO -p NAME:=VALUE --enclave NAME";

bool is_name(std::string_view text) {
  return !text.empty() && text.back() != '/' && text.find("//") == std::string_view::npos &&
         std::all_of(text.begin(), text.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '/'; });
}

std::string in_space(const std::string& space, const std::string& name) {
  if (name.front() == '/') return name;
  return (space == "/" ? "" : space) + "/" + name;
}

/// Removes quotes and brackets, for the syntax of settings: "[1.0, 2.0]" becomes "1.0,2.0", '["left"]'
/// becomes "left".
std::string plain(std::string text) {
  const auto wrapped = [&](char first, char last) {
    return text.size() > 1 && text.front() == first && text.back() == last;
  };
  if (wrapped('"', '"') || wrapped('\'', '\'')) return text.substr(1, text.size() - 2);
  if (!wrapped('[', ']')) return text;
  text = text.substr(1, text.size() - 2);
  text.erase(
      std::remove_if(text.begin(), text.end(), [](char c) { return c == ' ' || c == '"' || c == '\''; }),
      text.end());
  return text;
}

struct Rule {
  std::string from, to;
};

Rule split(std::string_view argument) {
  const std::size_t at = argument.find(":=");
  if (at == std::string_view::npos || at == 0)
    throw Error("'{}' is not NAME:=VALUE; {}", printable(argument), kUsage);
  return {std::string(argument.substr(0, at)), std::string(argument.substr(at + 2))};
}

/// Relative names of remappings are in the node's final namespace, wherever the arguments set it.
Names names_of(const std::vector<Rule>& rules) {
  Names names;
  for (const auto& [from, to] : rules) {
    if (from != "__node" && from != "__name" && from != "__ns") continue;
    const bool space = from == "__ns";
    if (!is_name(to) || (to.front() == '/') != space || (!space && to.find('/') != std::string::npos))
      throw Error("'{}' is not a valid {}", printable(to),
                  space ? "namespace, such as /left" : "node name, such as palpate");
    (space ? names.space : names.node) = to;
  }
  for (const auto& [from, to] : rules) {
    if (from.rfind("__", 0) == 0) continue;
    if (!is_name(from) || !is_name(to))
      throw Error("'{}:={}' are not names of topics or services", printable(from), printable(to));
    names.remaps[in_space(names.space, from)] = in_space(names.space, to);
  }
  return names;
}

}  // namespace

std::string Names::resolve(const std::string& name) const {
  const std::string full = in_space(space, name);
  const auto at = remaps.find(full);
  return at == remaps.end() ? full : at->second;
}

NodeArguments read_arguments(int argc, const char* const* argv) {
  NodeArguments result;
  std::vector<Rule> rules;
  bool ros = false;
  for (int k = 1; k < argc; ++k) {
    const std::string_view argument = argv[k];
    const bool remap = argument == "-r" || argument == "--remap",
               parameter = argument == "-p" || argument == "--param";
    if (argument == "--ros-args" || argument == "--") {
      ros = argument == "--ros-args";
    } else if (ros && (remap || parameter) && k + 1 < argc) {
      Rule rule = split(argv[++k]);
      if (remap)
        rules.push_back(std::move(rule));
      else
        result.parameters.push_back({rule.from, plain(rule.to)});
    } else if (ros && (argument == "-e" || argument == "--enclave") && k + 1 < argc) {
      result.enclave = argv[++k];
    } else {
      throw Error("'{}' is not an argument; {}", printable(argument), kUsage);
    }
  }
  result.names = names_of(rules);
  return result;
}

}  // namespace palpate::ros2

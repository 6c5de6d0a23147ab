// palpate completion: shell completion scripts, generated from the declared commands.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "command.h"

namespace palpate::cli {
namespace {

/// Commands listed by --help.
std::vector<const CLI::App*> commands_of(const CLI::App& root) {
  return root.get_subcommands([](const CLI::App* app) { return !app->get_group().empty(); });
}

/// All names of an option, with dashes.
std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const auto& name : option.get_snames()) names.push_back("-" + name);
  for (const auto& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

std::vector<std::string> all_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (auto& name : names_of(*option)) names.push_back(std::move(name));
  }
  return names;
}

/// Description without characters that are special in a zsh specification or inside single quotes.
std::string brief(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char c) { return c == '\'' || c == '[' || c == ']' || c == ':' || c == '\n'; }, ' ');
  return text;
}

std::string bash_script(const CLI::App& root) {
  std::string commands, cases;
  for (const CLI::App* command : commands_of(root)) {
    commands += command->get_name() + " ";
    cases += fmt::format("    {}) words='{}' ;;\n", command->get_name(), fmt::join(all_names(*command), " "));
  }
  return fmt::format(
      "# bash completion for palpate\n"
      "_palpate() {{\n"
      "  local current=${{COMP_WORDS[COMP_CWORD]}} words=''\n"
      "  if [[ $COMP_CWORD -eq 1 ]]; then\n"
      "    COMPREPLY=($(compgen -W '{}--help --version' -- \"$current\"))\n"
      "    return\n"
      "  fi\n"
      "  case ${{COMP_WORDS[1]}} in\n{}  esac\n"
      "  if [[ $current == -* ]]; then\n"
      "    COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
      "  else\n"
      "    COMPREPLY=($(compgen -f -- \"$current\"))\n"
      "  fi\n"
      "}}\n"
      "complete -o filenames -F _palpate palpate\n",
      commands, cases);
}

std::string zsh_script(const CLI::App& root) {
  std::string commands, cases;
  for (const CLI::App* command : commands_of(root)) {
    commands += fmt::format("    '{}:{}'\n", command->get_name(), brief(command->get_description()));
    cases += fmt::format("    {}) _arguments", command->get_name());
    for (const CLI::Option* option : command->get_options()) {
      const bool flag = option->get_expected_max() == 0;
      for (const auto& name : names_of(*option))
        cases +=
            fmt::format(" '{}[{}]{}'", name, brief(option->get_description()), flag ? "" : ":value:_files");
    }
    cases += " '*:file:_files' ;;\n";
  }
  return fmt::format(
      "#compdef palpate\n"
      "_palpate() {{\n"
      "  local -a commands=(\n{}  )\n"
      "  if (( CURRENT == 2 )); then\n"
      "    _describe command commands\n"
      "    return\n"
      "  fi\n"
      "  local command=${{words[2]}}\n"
      "  shift words; (( CURRENT-- ))\n"
      "  case $command in\n{}  esac\n"
      "}}\n"
      // At the first call of an autoloaded function, zsh executes its file as the body of the function.
      "if [[ ${{funcstack[1]:-}} == _palpate ]]; then _palpate \"$@\"; else compdef _palpate palpate; fi\n",
      commands, cases);
}

std::string fish_script(const CLI::App& root) {
  std::string text = "# fish completion for palpate\n";
  for (const CLI::App* command : commands_of(root)) {
    text += fmt::format("complete -c palpate -n __fish_use_subcommand -f -a {} -d '{}'\n",
                        command->get_name(), brief(command->get_description()));
    for (const CLI::Option* option : command->get_options()) {
      std::string names;
      for (const auto& name : option->get_snames()) names += " -s " + name;
      for (const auto& name : option->get_lnames()) names += " -l " + name;
      if (names.empty()) continue;
      const bool flag = option->get_expected_max() == 0;
      text += fmt::format("complete -c palpate -n '__fish_seen_subcommand_from {}'{}{} -d '{}'\n",
                          command->get_name(), names, flag ? "" : " -r", brief(option->get_description()));
    }
  }
  return text;
}

}  // namespace

Command declare_completion(CLI::App& parent) {
  CLI::App& app =
      add_command(parent, "completion", "Print a completion script: eval \"$(palpate completion bash)\"");
  auto shell = std::make_shared<std::string>();
  add_choice(app, "SHELL", *shell, {"bash", "zsh", "fish"}, "bash, zsh or fish").required();
  const CLI::App* root = &parent;
  return {&app, [=] {
            const std::string script = *shell == "bash"  ? bash_script(*root)
                                       : *shell == "zsh" ? zsh_script(*root)
                                                         : fish_script(*root);
            fmt::print("{}", script);
          }};
}

}  // namespace palpate::cli

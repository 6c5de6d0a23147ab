/// \file
/// Interface of subcommands: one file and one declaring function each.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "declare.h"

namespace palpate::cli {

/// A declared subcommand: its options, and the function to run once they are parsed.
struct Command {
  CLI::App* app;
  std::function<void()> run;  ///< throws Error
};

/// Options that every command has.
struct CommonOptions {
  bool quiet = false;
  bool json = false;
  std::string config;             ///< read before the arguments are parsed, see config.h
  const CLI::App* app = nullptr;  ///< the subcommand; lives as long as the program
};

Command declare_info(CLI::App& parent);
Command declare_setup(CLI::App& parent);
Command declare_query(CLI::App& parent);
Command declare_run(CLI::App& parent);
Command declare_replay(CLI::App& parent);
Command declare_report(CLI::App& parent);
Command declare_make_scene(CLI::App& parent);
Command declare_make_path(CLI::App& parent);
Command declare_bench(CLI::App& parent);
Command declare_evaluate(CLI::App& parent);
Command declare_stability(CLI::App& parent);
Command declare_reproduce(CLI::App& parent);
Command declare_completion(CLI::App& parent);
Command declare_columns(CLI::App& parent);
Command declare_man_page(CLI::App& parent);

/// Adds --quiet and --config, and --json with `json_help` if that is not empty.
void declare_common(CLI::App& app, CommonOptions& options, const std::string& json_help = "");

}  // namespace palpate::cli

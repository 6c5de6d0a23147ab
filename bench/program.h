/// \file
/// What the benchmark programs have in common: options and how they fail.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "comparison.h"

namespace palpate::bench {

/// For options that must be greater than zero.
CLI::Validator positive();

/// Files to write results to; empty for none.
struct ReportFiles {
  std::string json, markdown;
};
void declare_files(CLI::App& app, ReportFiles& files);

/// The options of a program that compares.
struct ProgramOptions {
  ComparisonOptions comparison;
  ReportFiles files;
};

/// Declares them all but the number of Gaussians.
void declare_options(CLI::App& app, ProgramOptions& options);

/// The names of all peers, for a check of an option.
std::vector<std::string> peer_names();

/// This library, and the peers that `wanted` holds for.
std::vector<Family> select_families(const std::function<bool(const std::string&)>& wanted);

/// Parses, then runs `body`. Every failure is one line on stderr: exit code 2 for bad usage, 1 for all else.
int run_program(CLI::App& app, int argc, char** argv, const std::function<void()>& body);

}  // namespace palpate::bench

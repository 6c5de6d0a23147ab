/// \file
/// Options and error handling shared by the benchmark programs.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "comparison.h"

namespace palpate::bench {

/// Validator of options that must be greater than zero.
CLI::Validator positive();

/// Output files of the results; empty: none.
struct ReportFiles {
  std::string json, markdown;
};
void declare_files(CLI::App& app, ReportFiles& files);

/// Options of a comparison program.
struct ProgramOptions {
  ComparisonOptions comparison;
  ReportFiles files;
};

/// Declares all options but the number of Gaussians.
void declare_options(CLI::App& app, ProgramOptions& options);

/// Names of all peers, to validate an option.
std::vector<std::string> peer_names();

/// This library, and the peers for which `wanted` is true.
std::vector<Family> select_families(const std::function<bool(const std::string&)>& wanted);

/// Parses the arguments and runs `body`. A failure prints one line on stderr.
/// \returns exit code: 2 for bad usage, 1 for other failures
int run_program(CLI::App& app, int argc, char** argv, const std::function<void()>& body);

}  // namespace palpate::bench

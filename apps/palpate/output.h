/// \file
/// Output functions shared by several commands.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <palpate/collision/paper_pipeline.h>
#include <palpate/haptics/tool.h>
#include <palpate/report/ordered_json.h>
#include <palpate/report/result_files.h>

namespace palpate::cli {

using Json = OrderedJson;

/// "palpate 0.1.0"
std::string program_version();

/// Prints one line on stderr: "palpate: " and the message, with unprintable characters replaced.
void notify(std::string_view message);

/// The line that notify() writes.
std::string notice(std::string_view message);

/// Prints indented JSON on stdout.
void print_json(const Json& json);

/// Short description of a tool: "20/20/40 mm", "24 ellipsoids".
std::string tool_in_words(const Tool& tool);

/// \throws Error if writing `out`, the value of `option`, would destroy one of `inputs` (empty names are
/// skipped).
void check_output(const std::string& out, const std::vector<std::string>& inputs,
                  std::string_view option = "--out");

/// \throws Error if `out`, the value of `option`, is given with another ending than `ending`, such as
/// ".html": the content would not be what its name says. A name without an ending is permitted.
void check_ending(const std::string& out, std::string_view ending, std::string_view option = "--out");

/// The same for the results of a measurement, the values of --csv, --html and --svg.
void check_results(const ResultNames& names, std::vector<std::string> inputs);

/// Prints the names of files, a line each.
void print_written(const std::vector<std::string>& files);

/// Adds `search_radius` and `can_miss`, the number of Gaussians out of reach of the paper's pipeline with
/// `tool`.
void add_reach(const PaperPipeline& paper, const Tool& tool, Json& json);

/// Prints the same as a sentence.
void print_reach(const PaperPipeline& paper, const Tool& tool);

}  // namespace palpate::cli

/// \file
/// Output functions shared by several commands.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include <palpate/collision/paper_pipeline.h>
#include <palpate/haptics/tool.h>
#include <palpate/report/ordered_json.h>

namespace palpate::cli {

using Json = OrderedJson;

/// "palpate 0.1.0"
std::string program_version();

/// One line on stderr: "palpate: " and the message, printable.
void notify(std::string_view message);

/// What notify() writes: a line of its own.
std::string notice(std::string_view message);

/// On stdout, indented.
void print_json(const Json& json);

/// The tool in a few words: "20/20/40 mm", "24 ellipsoids".
std::string tool_in_words(const Tool& tool);

/// \throws Error if writing `out`, the value of `option`, would destroy one of `inputs` (empty names are
/// skipped).
void check_output(const std::string& out, std::initializer_list<std::string> inputs,
                  std::string_view option = "--out");

/// Adds `search_radius` and `can_miss`: what the paper's pipeline does not reach with `tool`.
void add_reach(const PaperPipeline& paper, const Tool& tool, Json& json);

/// Prints the same in a sentence.
void print_reach(const PaperPipeline& paper, const Tool& tool);

}  // namespace palpate::cli

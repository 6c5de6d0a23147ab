/// \file
/// Pieces of output that several commands share.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include <palpate/collision/paper_pipeline.h>
#include <palpate/haptics/tool.h>

namespace palpate::cli {

using Json = nlohmann::ordered_json;

/// One line on stderr: "palpate: " and the message, printable.
void notify(std::string_view message);

/// What notify() writes: a line of its own.
std::string notice(std::string_view message);

/// Text that is not UTF-8, as of a file name, is replaced where it is not. \param indent -1: in one line
std::string json_text(const Json& json, int indent = -1);
/// On stdout, indented.
void print_json(const Json& json);

/// [x, y, z]
Json vector_json(const Eigen::Vector3d& v);

/// [{name, semi_axes, position, orientation}, ...], a part each, in the tool frame; m and w, x, y, z
Json tool_json(const Tool& tool);

/// The tool in a few words: "20/20/40 mm", "24 ellipsoids".
std::string tool_text(const Tool& tool);

/// \throws Error if writing `out`, the value of `option`, would destroy one of `inputs` (empty names are
/// skipped).
void check_output(const std::string& out, std::initializer_list<std::string> inputs,
                  std::string_view option = "--out");

/// Adds `search_radius` and `can_miss`: what the paper's pipeline does not reach with `tool`.
void add_reach(const PaperPipeline& paper, const Tool& tool, Json& json);

/// Prints the same in a sentence.
void print_reach(const PaperPipeline& paper, const Tool& tool);

}  // namespace palpate::cli

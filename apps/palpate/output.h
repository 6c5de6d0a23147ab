/// \file
/// Pieces of output that several commands share.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include <palpate/collision/paper_pipeline.h>
#include <palpate/haptics/tool.h>

namespace palpate::cli {

using Json = nlohmann::ordered_json;

/// [x, y, z]
Json vector_json(const Eigen::Vector3d& v);

/// Adds `search_radius` and `can_miss`: what the paper's pipeline does not reach with `tool`.
void add_reach(const PaperPipeline& paper, const Tool& tool, Json& json);

/// Prints the same in a sentence.
void print_reach(const PaperPipeline& paper, const Tool& tool);

}  // namespace palpate::cli

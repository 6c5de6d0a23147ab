/// \file
/// JSON with ordered keys, for command output and pages.
#pragma once

#include <string>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include <palpate/haptics/tool.h>

namespace palpate {

using OrderedJson = nlohmann::ordered_json;

/// Text that is not UTF-8, as of a file name, is replaced where it is not. \param indent -1: in one line
std::string json_text(const OrderedJson& json, int indent = -1);

/// [x, y, z]
OrderedJson vector_json(const Eigen::Vector3d& v);

/// [{name, semi_axes, position, orientation}, ...], a part each, in the tool frame; m and w, x, y, z
OrderedJson tool_json(const Tool& tool);

}  // namespace palpate

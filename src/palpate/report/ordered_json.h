/// \file
/// JSON with ordered keys, for command output and pages.
#pragma once

#include <string>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include <palpate/haptics/tool.h>

namespace palpate {

using OrderedJson = nlohmann::ordered_json;

/// Serializes `json`; bytes that are not UTF-8, as in file names, are replaced. \param indent -1: in one line
std::string json_text(const OrderedJson& json, int indent = -1);

/// [x, y, z]
OrderedJson vector_json(const Eigen::Vector3d& v);

/// [{name, semi_axes, position, orientation}, ...], one object per part, in the tool frame. Unit: [m];
/// quaternions w, x, y, z.
OrderedJson tool_json(const Tool& tool);

}  // namespace palpate

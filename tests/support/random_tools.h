/// \file
/// Random tools of many ellipsoids.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <palpate/haptics/tool.h>
#include <support/random_pairs.h>

namespace palpate::test {

/// `count` ellipsoids of semi-axes up to `size`, turned every way, their centres within 1.5 `size` of the
/// handle.
inline Tool random_tool(Random& random, int count, double size) {
  std::vector<ToolPart> parts;
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector3d semi_axes = size * random.semi_axes(0.3, 1.0);
    const Pose pose{size * random.vector(0.0, 1.5), random.rotation()};
    parts.push_back({"part " + std::to_string(k), semi_axes, pose});
  }
  return Tool(std::move(parts));
}

}  // namespace palpate::test

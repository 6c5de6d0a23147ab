/// \file
/// What the tests of the proxy have in common: a ball, surfaces of splats, and what they are made of.
#pragma once

#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include <palpate/haptics/material.h>
#include <palpate/study/procedural.h>

namespace palpate::test {

inline constexpr double kRadius = 0.02;       ///< of the ball. Unit: [m].
inline constexpr double kStiffness = 1000.0;  ///< Unit: [N/m].

/// Noise as captures have it, relative to the spacing.
inline ProceduralOptions noisy(std::uint64_t seed, double spacing = 0.006) {
  ProceduralOptions options;
  options.seed = seed;
  options.spacing = spacing;
  options.noise = 0.0015;
  options.tilt = 10.0 * std::numbers::pi / 180.0;
  return options;
}

/// All that there is of a material.
inline std::shared_ptr<const MaterialMap> everywhere(const Material& material) {
  return std::make_shared<MaterialMap>(std::vector<MaterialRegion>{{MaterialRegion::Everywhere{}, material}});
}

}  // namespace palpate::test

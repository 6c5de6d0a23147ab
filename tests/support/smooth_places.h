/// \file
/// Where a ball of 20 mm meets nothing but a smooth surface.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <palpate/study/procedural.h>
#include <palpate/study/random.h>

namespace palpate::test {

/// Samples of the surface away from its borders and edges.
inline std::vector<SurfaceSample> smooth_places(const AnalyticSurface& surface, const std::string& shape,
                                                std::size_t count, std::uint64_t seed) {
  palpate::Random random(seed);
  const auto samples = surface.samples(0.01, random);
  std::vector<SurfaceSample> chosen;
  while (chosen.size() < count) {
    const SurfaceSample& s = samples[random.index(samples.size())].sample;
    const Eigen::Vector3d& p = s.point;
    if (shape == "plane" && p.cwiseAbs().maxCoeff() > 0.13) continue;
    if (shape == "cylinder" && std::abs(p.z()) > 0.1) continue;
    if (shape == "shell" && p.z() < 0.05) continue;
    if (shape == "torus" && p.head<2>().norm() < 0.105) continue;  // the ball does not fit into the hole
    chosen.push_back(s);
  }
  return chosen;
}

}  // namespace palpate::test

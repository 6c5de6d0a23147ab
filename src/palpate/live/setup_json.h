/// \file
/// JSON form of a SceneSetup, for the command line and clients of the gateway.
#pragma once

#include <string>
#include <vector>

#include <palpate/scene/scene_setup.h>

namespace palpate {

/// Returns both corners of a box: the minimum x, y, z, then the maximum.
inline std::vector<double> corners(const Eigen::AlignedBox3d& box) {
  std::vector<double> all(box.min().begin(), box.min().end());
  all.insert(all.end(), box.max().begin(), box.max().end());
  return all;
}

/// Returns {frame, scale, opacity_min, max_scale, crop_box}, each {value, reason}; a value is null if nothing
/// is proposed.
/// \tparam J Json or OrderedJson
template <typename J>
J setup_json(const SceneSetup& setup) {
  const auto entry = [](const J& value, const std::string& reason) {
    return J{{"value", value}, {"reason", reason}};
  };
  const auto& longest = setup.max_scale.value;
  const auto& crop = setup.crop_box.value;
  return {{"frame", entry(to_string(setup.frame.value), setup.frame.reason)},
          {"scale", entry(setup.scale.value, setup.scale.reason)},
          {"opacity_min", entry(setup.opacity_min.value, setup.opacity_min.reason)},
          {"max_scale", entry(longest ? J(*longest) : J(), setup.max_scale.reason)},
          {"crop_box", entry(crop ? J(corners(*crop)) : J(), setup.crop_box.reason)}};
}

}  // namespace palpate

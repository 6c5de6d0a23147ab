/// \file
/// Scenes made by hand.
#pragma once

#include <cmath>
#include <initializer_list>
#include <vector>

#include <palpate/scene/gaussian_scene.h>

namespace palpate::test {

/// A Gaussian in its activated form.
struct Splat {
  Eigen::Vector3d position{0, 0, 0};
  Eigen::Vector3d sigma{0.01, 0.01, 0.01};
  double opacity = 0.9;
  Eigen::Vector4d rotation{1, 0, 0, 0};  ///< w, x, y, z
};

/// A scene in the linear encodings, so that round numbers stay round: alpha is exact to 1/255 only,
/// hence in the logit encoding.
inline GaussianScene scene_of(const std::vector<Splat>& splats) {
  GaussianScene scene;
  scene.source = "by hand";
  scene.scale_encoding = ScaleEncoding::kLinear;
  for (const Splat& s : splats) {
    scene.id.push_back(static_cast<std::uint32_t>(scene.id.size()));
    scene.position.push_back(s.position.cast<float>());
    scene.scale.push_back(s.sigma.cast<float>());
    scene.rotation.push_back(s.rotation.cast<float>());
    scene.opacity.push_back(static_cast<float>(std::log(s.opacity / (1.0 - s.opacity))));
  }
  return scene;
}

}  // namespace palpate::test

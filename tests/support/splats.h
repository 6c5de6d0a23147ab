/// \file
/// Scenes made by hand.
#pragma once

#include <cmath>
#include <cstdint>
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

/// One of orientation `q`.
inline Splat splat(const Eigen::Vector3d& position, const Eigen::Vector3d& sigma,
                   const Eigen::Quaterniond& q = Eigen::Quaterniond::Identity(), double opacity = 0.9) {
  return {position, sigma, opacity, {q.w(), q.x(), q.y(), q.z()}};
}

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

/// `scene` with ids that are not positions, as where rows of a file were dropped: 3 i + 5.
inline GaussianScene with_gaps_in_ids(GaussianScene scene) {
  for (std::size_t i = 0; i < scene.size(); ++i) scene.id[i] = static_cast<std::uint32_t>(3 * i + 5);
  return scene;
}

/// A linear scene in the logarithmic encoding. A sigma of zero becomes a logarithm of minus infinity.
inline GaussianScene in_logarithms(GaussianScene scene) {
  scene.scale_encoding = ScaleEncoding::kLog;
  for (Eigen::Vector3f& s : scene.scale) s = s.array().log();
  return scene;
}

/// A logit scene in bytes.
inline GaussianScene in_bytes(GaussianScene scene) {
  scene.opacity_encoding = OpacityEncoding::kByte;
  for (float& o : scene.opacity) o = std::round(255.0F / (1.0F + std::exp(-o)));
  return scene;
}

}  // namespace palpate::test

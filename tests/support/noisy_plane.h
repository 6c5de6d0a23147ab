/// \file
/// Planes at z = 0: one noisy as captures are, one even.
#pragma once

#include <numbers>

#include <palpate/collision/scene_index.h>
#include <palpate/study/procedural.h>

namespace palpate::test {

inline constexpr double kPlaneNoise = 0.0015;  ///< of noisy_plane(). Unit: [m].

/// 0.4 x 0.4 m of splats 6 mm apart.
/// \param noise how far they are displaced. Unit: [m].
/// \param tilt how far they are turned. Unit: [rad].
inline SceneIndex plane_of_splats(double noise, double tilt) {
  ProceduralOptions options;
  options.spacing = 0.006;
  options.noise = noise;
  options.tilt = tilt;
  return SceneIndex(make_scene(*make_surface("plane"), options), SceneFilter{}, Similarity{});
}

/// Displaced by 1.5 mm and tilted by 10 degrees. Made once a program.
inline const SceneIndex& noisy_plane() {
  static const SceneIndex index = plane_of_splats(kPlaneNoise, 10.0 * std::numbers::pi / 180.0);
  return index;
}

/// Neither displaced nor tilted. Made once a program.
inline const SceneIndex& even_plane() {
  static const SceneIndex index = plane_of_splats(0.0, 0.0);
  return index;
}

}  // namespace palpate::test

/// \file
/// A plane at z = 0, noisy as captures are.
#pragma once

#include <numbers>

#include <palpate/collision/scene_index.h>
#include <palpate/scene/procedural.h>

namespace palpate::test {

/// 0.4 x 0.4 m of splats 6 mm apart, displaced by 1.5 mm and tilted by 10 degrees. Made once a program.
inline const SceneIndex& noisy_plane() {
  static const SceneIndex index = [] {
    ProceduralOptions options;
    options.spacing = 0.006;
    options.noise = 0.0015;
    options.tilt = 10.0 * std::numbers::pi / 180.0;
    return SceneIndex(make_scene(*make_surface("plane"), options), SceneFilter{}, Similarity{});
  }();
  return index;
}

}  // namespace palpate::test

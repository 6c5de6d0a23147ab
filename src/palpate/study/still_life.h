/// \file
/// Procedural still-life scene, also the built-in scene.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <palpate/geometry/pose.h>
#include <palpate/haptics/id_set.h>
#include <palpate/haptics/material.h>
#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/ply_materials.h>
#include <palpate/study/analytic_shape.h>

namespace palpate {

/// One object of a still life.
struct StillLifeObject {
  std::string name;   ///< e.g. "orange"
  IdRange ids;        ///< its Gaussians
  Material material;  ///< stiffness and friction are set
  /// Shape without the relief, in a frame of its own; null if that is no elementary shape.
  std::shared_ptr<const AnalyticShape> shape;
  Pose pose;            ///< from that frame to the world
  double relief = 0.0;  ///< upper bound of the distance of its Gaussians' centres from `shape`. Unit: [m].
};

/// The scene and its objects.
struct StillLife {
  GaussianScene scene;
  std::vector<StillLifeObject> objects;  ///< in the order of their Gaussians; each Gaussian belongs to one
};

/// The name of the scene for `make-scene`, and of the built-in one.
inline constexpr const char* kStillLife = "still-life";

/// Mean distance of neighbours on the table; finer objects have 0.4 to 1 of it. About 250,000 Gaussians.
/// Unit: [m].
inline constexpr double kStillLifeSpacing = 0.0028;

/// A bowl of fruit on a crumpled cloth, grapes, a pear, a lemon, a log, a cairn of stones, and an engraved
/// plate of brass that leans on the log; on a table of 0.88 m x 0.62 m whose upper face is in z = 0 except
/// for its grain. Light is baked into the colours. In metres, z up. The same seed and spacing give the same
/// scene on every platform, up to the last bit where mathematical libraries differ; takes about a second.
/// \throws Error if the spacing is not in [0.001, 0.02] m.
StillLife make_still_life(std::uint64_t seed = 1, double spacing = kStillLifeSpacing);

/// Returns the materials as regions of a MaterialMap, by id and thus valid in any registration.
std::vector<MaterialRegion> material_regions(const StillLife& still_life);

/// Returns the materials as columns of a .ply.
PlyMaterials material_columns(const StillLife& still_life);

}  // namespace palpate

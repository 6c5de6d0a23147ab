/// \file
/// Materials of a scene: stiffness, friction and damping by place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include <palpate/haptics/id_set.h>
#include <palpate/scene/ply_materials.h>

namespace palpate {

/// Material properties. For an unset property the force model's own parameter applies.
struct Material {
  std::optional<double> stiffness = {};  ///< Unit: [N/m]. >= 0
  std::optional<double> friction = {};   ///< Coulomb's coefficient. >= 0
  std::optional<double> damping = {};    ///< Unit: [N s/m]. >= 0

  bool operator==(const Material&) const = default;
};

/// Returns `top`, with unset properties taken from `below`.
Material over(const Material& top, const Material& below);

/// The Gaussians with their centre within `radius` of `center`. World frame. Unit: [m].
struct MaterialSphere {
  Eigen::Vector3d center;
  double radius;
};

/// Region of Gaussians of one material. A box contains those with their centre in it (world frame, [m]),
/// faces included.
struct MaterialRegion {
  struct Everywhere {};
  using Shape = std::variant<Everywhere, Eigen::AlignedBox3d, MaterialSphere, IdSet>;

  Shape shape;
  Material material;

  /// Returns true if the region contains Gaussian `id`, whose centre is `center` in the world. Unit: [m].
  bool contains(std::uint32_t id, const Eigen::Vector3d& center) const;
};

/// The material of every Gaussian of a scene. Immutable: any number of threads may read concurrently.
class MaterialMap {
 public:
  MaterialMap() = default;
  /// Each property comes from the last region that contains the Gaussian and sets it, or else from the
  /// Gaussian's own row.
  explicit MaterialMap(std::vector<MaterialRegion> regions, PlyMaterials rows = {});

  /// True if no Gaussian has any property.
  bool empty() const { return regions_.empty() && rows_.empty(); }
  /// Number of regions.
  std::size_t size() const { return regions_.size(); }

  /// Returns the material of Gaussian `id`, whose centre is `center` in the world, in [m]. Does not throw or
  /// allocate; takes time proportional to the number of regions.
  Material of(std::uint32_t id, const Eigen::Vector3d& center) const;

 private:
  std::vector<MaterialRegion> regions_;  ///< topmost first
  PlyMaterials rows_;
};

}  // namespace palpate

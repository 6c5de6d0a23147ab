/// \file
/// What the scene is made of, where it is touched.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include <palpate/haptics/id_set.h>
#include <palpate/scene/ply_materials.h>

namespace palpate {

/// What something is made of. Where a property is not set, the force model's own parameter holds.
struct Material {
  std::optional<double> stiffness = {};  ///< Unit: [N/m]. >= 0
  std::optional<double> friction = {};   ///< Coulomb's coefficient. >= 0
  std::optional<double> damping = {};    ///< Unit: [N s/m]. >= 0

  bool operator==(const Material&) const = default;
};

/// `top`, and where it has no property, that of `below`.
Material over(const Material& top, const Material& below);

/// The Gaussians with their centre within `radius` of `center`. World frame. Unit: [m].
struct MaterialSphere {
  Eigen::Vector3d center;
  double radius;
};

/// Gaussians of one material. A box takes those with their centre in it (world frame, [m]), faces included.
struct MaterialRegion {
  struct Everywhere {};
  using Shape = std::variant<Everywhere, Eigen::AlignedBox3d, MaterialSphere, IdSet>;

  Shape shape;
  Material material;

  /// `center` is that of Gaussian `id`, in the world. Unit: [m].
  bool contains(std::uint32_t id, const Eigen::Vector3d& center) const;
};

/// The material of every Gaussian of a scene. Immutable: any number of threads may ask at once.
class MaterialMap {
 public:
  MaterialMap() = default;
  /// Each property is that of the last region that holds the Gaussian and has it, or else that of the
  /// Gaussian's own row.
  explicit MaterialMap(std::vector<MaterialRegion> regions, PlyMaterials rows = {});

  /// True if no Gaussian has any property.
  bool empty() const { return regions_.empty() && rows_.empty(); }

  /// Of Gaussian `id`, whose centre is `center` in the world, in [m]. Does not throw, takes nothing from the
  /// heap, and takes time proportional to the number of regions.
  Material of(std::uint32_t id, const Eigen::Vector3d& center) const;

 private:
  std::vector<MaterialRegion> regions_;  ///< what is on top first
  PlyMaterials rows_;
};

}  // namespace palpate

/// \file
/// Lookup of ellipsoids by Gaussian id.
#pragma once

#include <cstdint>
#include <vector>

#include <palpate/collision/scene_index.h>

namespace palpate {

/// Ellipsoids of an index by id, for visualisation; queries do not need it. Eight bytes per Gaussian, sorted
/// once. Immutable.
class EllipsoidLookup {
 public:
  /// `index` must outlive it and keep its memory; it may be re-registered (SceneIndex::registered()).
  explicit EllipsoidLookup(const SceneIndex& index);

  /// The ellipsoid of `id` in the world frame. \pre the index has a Gaussian of that id
  Ellipsoid at(std::uint32_t id) const;
  /// All ellipsoids in order of id, in the world frame; without colours.
  EllipsoidScene all() const;

 private:
  struct Place {
    std::uint32_t id;
    std::uint32_t slot;  ///< kIndexWidth times its block, and its lane
  };
  const SceneIndex& index_;
  std::vector<Place> places_;  ///< by id
};

}  // namespace palpate

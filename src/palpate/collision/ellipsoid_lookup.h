/// \file
/// From the id of a contact to the ellipsoid that was touched.
#pragma once

#include <cstdint>
#include <vector>

#include <palpate/collision/scene_index.h>

namespace palpate {

/// The ellipsoids of an index by their ids, for who shows them: a query itself has no need of it. Eight bytes
/// a Gaussian, sorted once. Immutable.
class EllipsoidLookup {
 public:
  /// `index` must outlive it, and be of that memory: registered() anew it may be.
  explicit EllipsoidLookup(const SceneIndex& index);

  /// In the world. \pre the index has a Gaussian of that id
  Ellipsoid at(std::uint32_t id) const;
  /// All of them, by id, in the world; without colours.
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

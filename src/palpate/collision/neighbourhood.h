/// \file
/// The Gaussians near a tool, kept for the poses that follow.
#pragma once

#include <memory>

#include <palpate/collision/scene_index.h>

namespace palpate {

struct CandidateSet;

/// The Gaussians that a solid touches, and where their K was least: enough to answer for every tool inside
/// that solid. Takes nothing from the heap after construction.
class Neighbourhood {
 public:
  Neighbourhood();
  ~Neighbourhood();

  /// Looks for what `solid` touches. \returns false if that is too much to keep; it then covers nothing.
  bool search(const SceneIndex& index, const Ellipsoid& solid, Precision precision);

  /// True if contacts() of `tool` are complete. May be false though they would be.
  bool covers(const Ellipsoid& tool) const;

  /// Those contacts of `tool` that are among it, by rounding the same as of a fresh query. The arguments are
  /// those of search().
  void contacts(const SceneIndex& index, const Ellipsoid& tool, Precision precision, ContactSet& result);

  /// How many Gaussians are kept.
  std::size_t size() const;

 private:
  std::unique_ptr<CandidateSet> candidates_;
  bool valid_ = false;
  Eigen::Vector3d center_;  ///< of the solid
  Eigen::Matrix3d W_;       ///< world to where the solid is the unit sphere
};

}  // namespace palpate

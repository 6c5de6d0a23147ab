/// \file
/// A scene that may move as a whole, seen from a frame that moves with it.
#pragma once

#include <cstdint>

#include <palpate/collision/scene_index.h>
#include <palpate/geometry/pose.h>

namespace palpate {

/// A copy of a SceneIndex to which another one may be assigned, in an anchor frame A fixed to its Gaussians:
/// where the same Gaussians are registered at another pose (SceneIndex::registered()), A moves in the world
/// and the copy does not change, so that whatever is known in A stays true. At first A is the world frame.
///
/// One thread. Copies share memory; follow() releases that of an index that was replaced by other Gaussians.
class AnchoredScene {
 public:
  /// \param index must outlive it
  explicit AnchoredScene(const SceneIndex& index) : index_(index), epoch_(index.epoch()), scene_(index) {}
  AnchoredScene(const AnchoredScene&) = delete;
  AnchoredScene& operator=(const AnchoredScene&) = delete;

  /// Reads the index anew. \returns false if it has other Gaussians, or the same at another scale: then
  /// nothing known of them is true any more, and A stays where it is in the world
  bool follow();

  /// The index, registered in A. The object stays the same.
  const SceneIndex& scene() const { return scene_; }
  /// True unless A is the world frame.
  bool has_moved() const { return has_moved_; }
  /// Pose of A in the world.
  const Pose& X_WA() const { return X_WA_; }

  /// Largest relative difference of scales that are the same: that of rounding where poses are composed.
  static constexpr double kSameScale = 1e-9;

 private:
  const SceneIndex& index_;
  std::uint64_t epoch_;  ///< of the index when last read
  SceneIndex scene_;
  Pose X_WA_;
  bool has_moved_ = false;
};

}  // namespace palpate

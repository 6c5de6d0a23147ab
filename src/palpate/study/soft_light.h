/// \file
/// Sky and window light with soft shadows, for colours baked into a scene.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include <Eigen/Core>

namespace palpate {

/// An object that occludes others and casts a shadow.
struct Occluder {
  Eigen::Vector3d center;  ///< of a ball that holds it
  double radius;           ///< of that ball. Unit: [m].
  /// Signed distance of a point of the world, not above the true one by more than a millimetre. Unit: [m].
  std::function<double(const Eigen::Vector3d&)> distance;
  int object;  ///< whose it is
};

/// How much of each light reaches a point, in [0, 1].
struct Visibility {
  double sky = 1.0;
  double window = 1.0;
};

/// The things of a scene, as light sees them. Immutable once they are all there; any thread.
class SoftLight {
 public:
  void add(Occluder occluder) { occluders_.push_back(std::move(occluder)); }

  /// Of the nearest one, but for those of the object `but`; exact only where it is below `until`, and at
  /// least `until` elsewhere. Unit: [m].
  double distance(const Eigen::Vector3d& p, double until, int but = -1) const;

  /// Of a point on a surface with the outward `normal`, of unit length.
  Visibility visibility(const Eigen::Vector3d& p, const Eigen::Vector3d& normal) const;

 private:
  std::vector<Occluder> occluders_;
};

/// Towards the window, of unit length.
Eigen::Vector3d window_direction();

/// What is seen of a matt surface of the linear colour `albedo` (with `gloss` in [0, 1] of a highlight) in
/// the light that reaches it; linear.
Eigen::Vector3d lit(const Eigen::Vector3d& albedo, double gloss, const Eigen::Vector3d& normal,
                    const Visibility& visibility);

}  // namespace palpate

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
  Eigen::Vector3d center;  ///< of a bounding ball
  double radius;           ///< of that ball. Unit: [m].
  /// Signed distance of a point in the world frame, at most a millimetre above the true one. Unit: [m].
  std::function<double(const Eigen::Vector3d&)> distance;
  int object;  ///< index of the object that it belongs to
};

/// Fraction of each light that reaches a point, in [0, 1].
struct Visibility {
  double sky = 1.0;
  double window = 1.0;
};

/// Occluders of a scene. Any thread may query them once all are added.
class SoftLight {
 public:
  void add(Occluder occluder) { occluders_.push_back(std::move(occluder)); }

  /// Distance to the nearest occluder that is not of the object `but`, or `until` if that is less. Unit: [m].
  double distance(const Eigen::Vector3d& p, double until, int but = -1) const;

  /// Visibility at a point of a surface with the outward unit `normal`.
  Visibility visibility(const Eigen::Vector3d& p, const Eigen::Vector3d& normal) const;

 private:
  std::vector<Occluder> occluders_;
};

/// Unit vector towards the window.
Eigen::Vector3d window_direction();

/// Linear colour seen of a matt surface of the linear colour `albedo`, with a highlight of strength `gloss`
/// in [0, 1], in the light that reaches it.
Eigen::Vector3d lit(const Eigen::Vector3d& albedo, double gloss, const Eigen::Vector3d& normal,
                    const Visibility& visibility);

}  // namespace palpate

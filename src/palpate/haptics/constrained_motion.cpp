#include <palpate/haptics/constrained_motion.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace palpate {
namespace {

/// Largest number of sweeps, and the change that ends them: a hundredth of a device's resolution. Unit: [m].
constexpr int kSweeps = 128;
constexpr double kSmall = 1e-8;

/// Largest number of planes examined in all sweeps: 0.1 ms. With so many planes that this ends the sweeps
/// early, the motion enters a plane slightly, and the next one leaves it.
constexpr std::size_t kMostRelaxed = kSweeps * kMostPlanesSolved;

/// Gauss-Seidel iteration from the wanted to the constrained motion. \param gyration as for length_of().
/// Unit: [m].
class Solver {
 public:
  Solver(const Motion& wanted, double gyration, std::span<MotionConstraint> planes)
      : motion_(wanted), inverse_inertia_(1.0 / (gyration * gyration)) {
    double farthest = 0.0;  // largest distance of a point from the handle, squared
    for (MotionConstraint& plane : planes) {
      plane.push = plane.clear_until = 0.0;
      plane.drag.setZero();
      farthest = std::max(farthest, plane.arm.squaredNorm());
    }
    way_of_push_ = 1.0 + inverse_inertia_ * farthest;
  }

  const Motion& motion() const { return motion_; }
  /// Number of planes examined.
  std::size_t relaxed() const { return relaxed_; }

  /// Removes the violation of `plane` by the motion. \returns the change of its push and drag. Unit: [m].
  double relax(MotionConstraint& plane) {
    // Most planes of a tool of many parts are far from it: they are skipped until others have moved it there.
    if (way_ < plane.clear_until) return 0.0;
    ++relaxed_;
    const double missing = -(plane.gap + plane.normal.dot(plane.of(motion_)));
    if (plane.push == 0.0 && missing < 0.0) {
      plane.clear_until = way_ - missing - kSmall;
      return 0.0;
    }
    const double step = std::max(-plane.push, missing / give(plane, plane.normal));
    plane.push += step;
    apply(plane, step * plane.normal);
    return plane.friction > 0.0 ? std::max(std::abs(step), drag(plane)) : std::abs(step);
  }

 private:
  /// Displacement of the point along `direction` per unit of push in that direction.
  double give(const MotionConstraint& plane, const Eigen::Vector3d& direction) const {
    return 1.0 + inverse_inertia_ * plane.arm.cross(direction).squaredNorm();
  }

  void apply(const MotionConstraint& plane, const Eigen::Vector3d& push) {
    way_ += way_of_push_ * push.norm();
    motion_.translation += push;
    motion_.rotation += inverse_inertia_ * plane.arm.cross(push);
  }

  double drag(MotionConstraint& plane) {
    const Eigen::Vector3d before = plane.drag, slip = plane.of(motion_);
    const Eigen::Vector3d u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
    plane.drag -= slip.dot(u) / give(plane, u) * u + slip.dot(v) / give(plane, v) * v;
    const double most = plane.friction * plane.push, size = plane.drag.norm();
    if (size > most) plane.drag *= most / size;
    apply(plane, plane.drag - before);
    return (plane.drag - before).norm();
  }

  Motion motion_;
  double inverse_inertia_;  ///< Unit: [1/m^2].
  double way_ = 0.0;        ///< upper bound of the displacement of any point so far. Unit: [m].
  std::size_t relaxed_ = 0;
  double way_of_push_;  ///< upper bound of the displacement of any point per push. Unit: [m/m].
};

}  // namespace

double length_of(const Motion& motion, double gyration) {
  return std::hypot(motion.translation.norm(), gyration * motion.rotation.norm());
}

Motion constrained_motion(const Motion& wanted, std::span<MotionConstraint> planes, double gyration) {
  Solver solver(wanted, gyration, planes);
  for (int sweep = 0; sweep < kSweeps && solver.relaxed() < kMostRelaxed; ++sweep) {
    double change = 0.0;
    for (MotionConstraint& plane : planes) change = std::max(change, solver.relax(plane));
    if (change < kSmall) break;
  }
  return solver.motion();
}

}  // namespace palpate

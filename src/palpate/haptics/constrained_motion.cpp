#include <palpate/haptics/constrained_motion.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace palpate {
namespace {

/// Sweeps at most, and the change, in metres, that ends them: a hundredth of what a device resolves.
constexpr int kSweeps = 128;
constexpr double kSmall = 1e-8;

/// A motion on the way to its end. \param gyration as for length_of(). Unit: [m].
class Solver {
 public:
  Solver(const Motion& wanted, double gyration)
      : motion_(wanted), inverse_inertia_(1.0 / (gyration * gyration)) {}

  const Motion& motion() const { return motion_; }

  /// Mends what `plane` has against the motion. \returns the change of its push and drag. Unit: [m].
  double relax(MotionConstraint& plane) {
    const double missing = -(plane.gap + plane.normal.dot(plane.of(motion_)));
    const double step = std::max(-plane.push, missing / give(plane, plane.normal));
    plane.push += step;
    apply(plane, step * plane.normal);
    return plane.friction > 0.0 ? std::max(std::abs(step), drag(plane)) : std::abs(step);
  }

 private:
  /// How far the point moves along `direction` for a unit of push that way.
  double give(const MotionConstraint& plane, const Eigen::Vector3d& direction) const {
    return 1.0 + inverse_inertia_ * plane.arm.cross(direction).squaredNorm();
  }

  void apply(const MotionConstraint& plane, const Eigen::Vector3d& push) {
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
};

}  // namespace

double length_of(const Motion& motion, double gyration) {
  return std::hypot(motion.translation.norm(), gyration * motion.rotation.norm());
}

Motion constrained_motion(const Motion& wanted, std::span<MotionConstraint> planes, double gyration) {
  Solver solver(wanted, gyration);
  for (MotionConstraint& plane : planes) {
    plane.push = 0.0;
    plane.drag.setZero();
  }
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double change = 0.0;
    for (MotionConstraint& plane : planes) change = std::max(change, solver.relax(plane));
    if (change < kSmall) break;
  }
  return solver.motion();
}

}  // namespace palpate

#include <palpate/haptics/constrained_motion.h>

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

/// Sweeps at most, and the change, in metres, that ends them: a hundredth of what a device resolves.
constexpr int kSweeps = 64;
constexpr double kSmall = 1e-8;

}  // namespace

double length_of(const Motion& motion, double gyration) {
  return std::hypot(motion.translation.norm(), gyration * motion.rotation.norm());
}

Motion constrained_motion(const Motion& wanted, std::span<MotionConstraint> planes, double gyration) {
  Motion motion = wanted;
  const double inverse_inertia = 1.0 / (gyration * gyration);
  for (MotionConstraint& plane : planes) plane.push = 0.0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double change = 0.0;
    for (MotionConstraint& plane : planes) {
      const double missing = -(plane.gap + plane.along(motion) + plane.compliance * plane.push);
      const double give = 1.0 + inverse_inertia * plane.lever.squaredNorm() + plane.compliance;
      const double step = std::max(-plane.push, missing / give);
      plane.push += step;
      motion.translation += step * plane.normal;
      motion.rotation += (inverse_inertia * step) * plane.lever;
      change = std::max(change, std::abs(step));
    }
    if (change < kSmall) break;
  }
  return motion;
}

}  // namespace palpate

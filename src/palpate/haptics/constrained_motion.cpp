#include <palpate/haptics/constrained_motion.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace palpate {
namespace {

/// Sweeps at most, and the change, in metres, that ends them: a hundredth of what a device resolves.
constexpr int kSweeps = 64;
constexpr double kSmall = 1e-8;

}  // namespace

double length_of(const Motion& motion, double gyration) {
  return std::hypot(motion.translation.norm(), gyration * motion.rotation.norm());
}

ConstrainedMotion constrained_motion(const Motion& wanted, std::span<const SurfacePatch> planes,
                                     const Eigen::Vector3d& handle, double gyration) {
  ConstrainedMotion result{wanted, false};
  Motion& motion = result.motion;
  std::array<double, SurfacePatches::kMost> push{};  // multipliers. Unit: [m].
  const double inverse_inertia = 1.0 / (gyration * gyration);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double change = 0.0;
    for (std::size_t k = 0; k < planes.size(); ++k) {
      const Eigen::Vector3d& n = planes[k].normal;
      const Eigen::Vector3d lever = (planes[k].foot - handle).cross(n);
      const double gap = planes[k].gap + n.dot(motion.translation) + lever.dot(motion.rotation);
      const double step = std::max(-push[k], -gap / (1.0 + inverse_inertia * lever.squaredNorm()));
      push[k] += step;
      motion.translation += step * n;
      motion.rotation += (inverse_inertia * step) * lever;
      change = std::max(change, std::abs(step));
    }
    if (change < kSmall) break;
  }
  for (std::size_t k = 0; k < planes.size(); ++k) result.held = result.held || push[k] > 0.0;
  return result;
}

}  // namespace palpate

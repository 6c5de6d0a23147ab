#include <palpate/haptics/surface_fit.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace palpate {
namespace {

/// A contact has its whole weight from this K_min on; below, it fades.
constexpr double kFullOverlap = 0.3;
/// A contact belongs to a patch wholly if their normals are within 53 degrees, and not at all from 78 degrees
/// on: at two deviations of the kernel normals differ by some 45 degrees, and by 90 across a corner of a box.
constexpr double kOtherPatch = 0.2, kSamePatch = 0.6;
/// Square of where the kernel (1 - r^2 / end)^3 ends, in deviations: its own is one.
constexpr double kKernelEnd = 10.0;
/// Slope and curvature are held back as by this many contacts, at one deviation, that say there is none:
/// nothing to a well covered surface, all to a single Gaussian, whose own normal then counts.
constexpr double kSlopePrior = 0.5, kCurvaturePrior = 1.0;
/// Fits of a new patch, since its foot moves to where its normal is. One that was there has been fitted a
/// tick ago.
constexpr int kFirstRounds = 4;
/// Contacts that no patch explains make one of their own if one of them has this K_min.
constexpr double kUnexplained = 0.15;
/// Patches are one if their normals are within 25 degrees.
constexpr double kOnePatch = 0.9;

/// 0 for x <= 0, 1 for x >= 1, smooth between.
double smooth_step(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// How much a contact of normal `n` belongs to a patch.
double belongs(const SurfacePatch& patch, const Eigen::Vector3d& n) {
  return smooth_step((n.dot(patch.normal) - kOtherPatch) / (kSamePatch - kOtherPatch));
}

/// The point of the tool's surface that is farthest along -n.
Eigen::Vector3d foot_of(const Ellipsoid& tool, const Eigen::Vector3d& n) {
  const Eigen::Vector3d along = tool.axes.transpose() * n;
  return tool.center - tool.axes * (along / along.norm());
}

}  // namespace

SurfaceKernel SurfaceKernel::for_tool(double a_min, double detail) {
  return {detail, std::hypot(a_min, 2.0 * detail) - a_min};
}

bool SurfacePatches::fit(std::span<const Contact> contacts, const Ellipsoid& tool, int rounds,
                         SurfacePatch& patch) const {
  for (int round = 0; round < rounds; ++round) {
    const Eigen::Vector3d n = patch.normal, foot = foot_of(tool, n);
    const Eigen::Vector3d u = n.unitOrthogonal(), v = n.cross(u);
    Eigen::Matrix4d normal_matrix = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    double most = 0.0, sum = 0.0;
    for (const Contact& c : contacts) {
      const double same = belongs(patch, c.normal);
      if (same == 0.0) continue;
      const Eigen::Vector3d q = (c.point - foot) / kernel_.detail;
      const double x = q.dot(u), y = q.dot(v), z = q.dot(n), squared = x * x + y * y;
      if (squared >= kKernelEnd) continue;
      const double near = 1.0 - squared / kKernelEnd;
      const double w = c.opacity * smooth_step(c.k_min / kFullOverlap) * near * near * near * same;
      const Eigen::Vector4d basis(1.0, x, y, squared);
      normal_matrix += (w * basis) * basis.transpose();
      right += (w * z) * basis;
      most = std::max(most, w);
      sum += w;
    }
    if (!(most > 1e-9)) return false;
    normal_matrix.diagonal() += most * Eigen::Vector4d(0.0, kSlopePrior, kSlopePrior, kCurvaturePrior);
    const Eigen::Vector4d fitted = normal_matrix.ldlt().solve(right);
    const Eigen::Vector3d surface = foot + kernel_.detail * fitted[0] * n;
    patch.normal = (n - fitted[1] * u - fitted[2] * v).normalized();
    patch.foot = foot_of(tool, patch.normal);
    patch.gap = patch.normal.dot(patch.foot - surface);
    patch.support = sum;
  }
  return true;
}

void SurfacePatches::keep_if_new(const SurfacePatch& patch) {
  for (const SurfacePatch& other : patches()) {
    if (other.normal.dot(patch.normal) > kOnePatch) return;
  }
  patches_[size_++] = patch;
}

void SurfacePatches::update(std::span<const Contact> contacts, const Ellipsoid& tool) {
  const std::size_t before = size_;
  size_ = 0;
  for (std::size_t i = 0; i < before; ++i) {
    SurfacePatch patch = patches_[i];  // patches_ is filled again from the front
    if (fit(contacts, tool, 1, patch)) keep_if_new(patch);
  }
  while (size_ < kMost) {
    const Contact* seed = nullptr;
    double largest = kUnexplained;
    for (const Contact& c : contacts) {
      double explained = 0.0;
      for (const SurfacePatch& patch : patches()) explained = std::max(explained, belongs(patch, c.normal));
      const double left = c.k_min * (1.0 - explained);
      if (left > largest) {
        largest = left;
        seed = &c;
      }
    }
    if (seed == nullptr) return;
    SurfacePatch patch;
    patch.normal = seed->normal;
    if (!fit(contacts, tool, kFirstRounds, patch)) return;
    const std::size_t known = size_;
    keep_if_new(patch);
    if (size_ == known) return;
  }
}

}  // namespace palpate

#include <palpate/haptics/surface_fit.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace palpate {
namespace {

/// Slope and curvature are held back as by this many contacts, at one deviation, that say there is none:
/// nothing to a well covered surface, all to a single Gaussian, whose own normal then counts.
constexpr double kSlopePrior = 0.5, kCurvaturePrior = 1.0;
/// Fits of a new patch, since its foot moves to where its normal is. One that was there has been fitted a
/// tick ago.
constexpr int kFirstRounds = 4;
/// Contacts that no patch explains make one of their own if one of them has this K_min.
constexpr float kUnexplained = 0.15F;
/// Patches are one if their normals are within 25 degrees.
constexpr double kOnePatch = 0.9;
/// A surface is whole where this many Gaussians, on average, lie over each other. Splats are trained to
/// overlap: a hundredth of a capture's surfaces have fewer, a floater that is half as large as the detail has
/// as many.
constexpr double kCovered = 0.25;
/// What lets less than a tenth of the light through is as hard as what lets none through.
constexpr double kOpaque = 0.9;

/// The point of the solid's surface that is farthest along -n.
Eigen::Vector3d foot_of(const Ellipsoid& solid, const Eigen::Vector3d& n) {
  const Eigen::Vector3d along = solid.axes.transpose() * n;
  return solid.center - solid.axes * (along / along.norm());
}

/// Height, slopes and mean curvature.
Eigen::Vector4d solve(const SurfaceMoments& moments) {
  const auto& m = moments.normal_matrix;
  Eigen::Matrix4f matrix;
  matrix << m[0], m[1], m[2], m[3],  //
      m[1], m[4], m[5], m[6],        //
      m[2], m[5], m[7], m[8],        //
      m[3], m[6], m[8], m[9];
  Eigen::Matrix4d held = matrix.cast<double>();
  held.diagonal() +=
      static_cast<double>(moments.heaviest) * Eigen::Vector4d(0.0, kSlopePrior, kSlopePrior, kCurvaturePrior);
  const auto& b = moments.right;
  return held.ldlt().solve(Eigen::Vector4f(b[0], b[1], b[2], b[3]).cast<double>());
}

/// The contact that no patch explains, if it is a deep one.
std::optional<std::size_t> unexplained(const SurfaceContacts& contacts) {
  std::optional<std::size_t> found;
  float most = kUnexplained;
  const float* const overlap = contacts.lane(SurfaceContacts::kOverlap);
  const float* const explained = contacts.lane(SurfaceContacts::kExplained);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const float left = overlap[i] * (1.0F - explained[i]);
    if (left > most) {
      most = left;
      found = i;
    }
  }
  return found;
}

}  // namespace

double confidence_of(const SurfaceMoments& moments) {
  const double layers = moments.layers;
  if (!(layers > 0.0)) return 0.0;
  const double covered = std::min(1.0, layers / kCovered);
  const double each = std::min(1.0, moments.opacity / layers);
  const double hidden = 1.0 - std::pow(1.0 - each, std::max(1.0, layers));
  return covered * covered * (3.0 - 2.0 * covered) * std::min(1.0, hidden / kOpaque);
}

bool SurfacePatches::fit(SurfaceContacts& contacts, const Ellipsoid& solid, int rounds,
                         SurfacePatch& patch) const {
  for (int round = 0; round < rounds; ++round) {
    const Eigen::Vector3d n = patch.normal, foot = foot_of(solid, n);
    const Eigen::Vector3d u = n.unitOrthogonal(), v = n.cross(u);
    const SurfaceFrame frame{((foot - solid.center) / kernel_.detail).cast<float>(), u.cast<float>(),
                             v.cast<float>(), n.cast<float>()};
    const SurfaceMoments moments = surface_moments(contacts, frame);
    if (!(moments.heaviest > 1e-9F)) return false;
    const Eigen::Vector4d fitted = solve(moments);
    const Eigen::Vector3d surface = foot + kernel_.detail * fitted[0] * n;
    patch.normal = (n - fitted[1] * u - fitted[2] * v).normalized();
    patch.foot = foot_of(solid, patch.normal);
    patch.gap = patch.normal.dot(patch.foot - surface);
    patch.confidence = confidence_of(moments);
  }
  return true;
}

bool SurfacePatches::keep_if_new(const SurfacePatch& patch) {
  for (const SurfacePatch& other : patches()) {
    if (other.normal.dot(patch.normal) > kOnePatch) return false;
  }
  patches_[size_++] = patch;
  return true;
}

void SurfacePatches::update(SurfaceContacts& contacts, const Ellipsoid& solid) {
  const std::size_t before = size_;
  size_ = 0;
  for (std::size_t i = 0; i < before; ++i) {
    SurfacePatch patch = patches_[i];  // patches_ is filled again from the front
    if (fit(contacts, solid, 1, patch)) keep_if_new(patch);
  }
  while (size_ < kMost) {
    const auto seed = unexplained(contacts);
    if (!seed) return;
    SurfacePatch patch;
    patch.normal = contacts.normal(*seed);
    if (!fit(contacts, solid, kFirstRounds, patch) || !keep_if_new(patch)) return;
  }
}

}  // namespace palpate

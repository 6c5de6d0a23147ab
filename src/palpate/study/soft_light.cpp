#include <palpate/study/soft_light.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate {
namespace {

using Eigen::Vector3d;

const Vector3d kSky(0.40, 0.46, 0.55);     // linear, from above
const Vector3d kBounce(0.26, 0.20, 0.15);  // from surrounding objects
const Vector3d kWindowLight(1.95, 1.76, 1.46);
const Vector3d kSeenFrom(0.54, -0.68, 0.5);  // direction of the initial viewpoint, for highlights

/// Distances along the normal at which ambient occlusion is probed, and their weights.
constexpr std::array<double, 5> kProbes{0.004, 0.010, 0.022, 0.045, 0.080};  // Unit: [m].
constexpr std::array<double, 5> kProbeShares{0.24, 0.24, 0.22, 0.18, 0.12};

constexpr double kShadowBegin = 0.004;  // off the surface, so that it does not shade itself. Unit: [m].
constexpr double kShadowEnd = 0.5;      // Unit: [m].
constexpr double kSharpness = 7.0;      // of a shadow's border: inverse of half the window's angular width
constexpr int kShadowSteps = 24;
constexpr double kLeastStep = 0.004;  // Unit: [m].

}  // namespace

double SoftLight::distance(const Vector3d& p, double until, int but) const {
  double least = until;
  for (const Occluder& o : occluders_) {
    if (o.object == but) continue;
    const double reach = o.radius + least;
    if (reach > 0.0 && (p - o.center).squaredNorm() < reach * reach) least = std::min(least, o.distance(p));
  }
  return least;
}

Visibility SoftLight::visibility(const Vector3d& p, const Vector3d& normal) const {
  Visibility result;
  double covered = 0.0;
  for (std::size_t k = 0; k < kProbes.size(); ++k) {
    const double room = distance(p + kProbes[k] * normal, kProbes[k]);
    covered += kProbeShares[k] * (1.0 - std::clamp(room / kProbes[k], 0.0, 1.0));
  }
  result.sky = std::clamp(1.0 - 1.15 * covered, 0.08, 1.0);
  const Vector3d towards = window_direction();
  double t = 2.0 * kShadowBegin, seen = 1.0;
  const Vector3d begin = p + kShadowBegin * normal;
  for (int step = 0; step < kShadowSteps && t < kShadowEnd && seen > 0.01; ++step) {
    const double room = distance(begin + t * towards, 0.12);
    seen = std::min(seen, kSharpness * room / t);
    t += std::max(room, kLeastStep);
  }
  const double s = std::clamp(seen, 0.0, 1.0);
  result.window = s * s * (3.0 - 2.0 * s);
  return result;
}

Vector3d window_direction() { return Vector3d(-0.70, -0.30, 0.60).normalized(); }

Vector3d lit(const Vector3d& albedo, double gloss, const Vector3d& normal, const Visibility& visibility) {
  const double up = 0.5 + 0.5 * normal.z();
  const double facing = std::max(0.0, normal.dot(window_direction()));
  const Vector3d sky = visibility.sky * (up * kSky + (1.0 - up) * kBounce);
  const Vector3d light = sky + (facing * visibility.window) * kWindowLight;
  Vector3d seen = albedo.cwiseProduct(light);
  if (gloss > 0.0) {
    const Vector3d half = (window_direction() + kSeenFrom.normalized()).normalized();
    double shine = std::max(0.0, normal.dot(half));
    for (int k = 0; k < 5; ++k) shine *= shine;  // 32nd power
    const double edge = 1.0 - std::max(0.0, normal.dot(kSeenFrom.normalized()));
    seen += gloss * (0.75 * shine * visibility.window * kWindowLight + 0.25 * edge * edge * edge * sky);
  }
  return seen;
}

}  // namespace palpate

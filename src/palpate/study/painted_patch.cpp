#include <palpate/study/painted_patch.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

namespace palpate {
namespace {

using Eigen::Vector3d;

/// Largest offset of a sample from the middle of its cell, as a fraction of it: enough to break the lattice.
constexpr double kSampleJitter = 0.25;
/// Standard deviations in the plane of a splat, in sides of its cell, so that a sheet has no gaps; and their
/// relative variation, as of trained splats.
constexpr double kPatchTangentSigma = 0.65;
constexpr double kPatchTangentVariation = 0.15;
constexpr double kPatchNormalSigma = 0.06;
constexpr double kPatchOpacityMin = 0.8;
constexpr double kPatchOpacityMax = 0.99;
/// Depth in another object from which a place is covered. Unit: [m].
constexpr double kCovered = 0.0005;
/// Sides of the cells of the light grid, in spacings: light varies slowly.
constexpr double kLightCell = 3.0;
/// Least parameter step over which a slope is taken.
constexpr double kLeastParameterStep = 1e-4;

double length_along_u(const PaintedPatch& patch, double v) {
  constexpr int kPieces = 24;
  double length = 0.0;
  Vector3d last = patch.at(0.0, v);
  for (int k = 1; k <= kPieces; ++k) {
    const Vector3d next = patch.at(static_cast<double>(k) / kPieces, v);
    length += (next - last).norm();
    last = next;
  }
  return length;
}

double length_along_v(const PaintedPatch& patch, double u) {
  constexpr int kPieces = 48;
  double length = 0.0;
  Vector3d last = patch.at(u, 0.0);
  for (int k = 1; k <= kPieces; ++k) {
    const Vector3d next = patch.at(u, static_cast<double>(k) / kPieces);
    length += (next - last).norm();
    last = next;
  }
  return length;
}

std::size_t cells(double length, double spacing) {
  return static_cast<std::size_t>(std::max(1.0, std::round(length / spacing)));
}

/// Tangents over a parameter step, each as long as the step on the surface.
struct Slopes {
  Vector3d along_u, along_v;
  Vector3d normal() const { return along_u.cross(along_v).normalized(); }
};

Slopes slopes_at(const PaintedPatch& patch, double u, double v, double du, double dv) {
  // Clamped to the square: beyond a pole, the surface would turn over.
  const double low = std::max(0.0, v - 0.5 * dv), high = std::min(1.0, v + 0.5 * dv);
  return {patch.at(u + 0.5 * du, v) - patch.at(u - 0.5 * du, v),
          (patch.at(u, high) - patch.at(u, low)) * (dv / (high - low))};
}

/// Visibility on a lattice over the unit square, with bilinear interpolation.
class LightGrid {
 public:
  LightGrid(const PaintedPatch& patch, const SoftLight& light, std::size_t columns, std::size_t rows)
      : columns_(columns), rows_(rows) {
    values_.reserve((columns + 1) * (rows + 1));
    const double du = 1.0 / static_cast<double>(columns), dv = 1.0 / static_cast<double>(rows);
    for (std::size_t j = 0; j <= rows; ++j) {
      for (std::size_t i = 0; i <= columns; ++i) {
        // Not at a pole, which has no normal.
        const double u = static_cast<double>(i) * du;
        const double v = std::clamp(static_cast<double>(j) * dv, 0.2 * dv, 1.0 - 0.2 * dv);
        values_.push_back(
            light.visibility(patch.at(u, v), slopes_at(patch, u, v, 0.5 * du, 0.3 * dv).normal()));
      }
    }
  }

  Visibility at(double u, double v) const {
    const double x = std::clamp(u, 0.0, 1.0) * static_cast<double>(columns_);
    const double y = std::clamp(v, 0.0, 1.0) * static_cast<double>(rows_);
    const auto i = std::min(static_cast<std::size_t>(x), columns_ - 1);
    const auto j = std::min(static_cast<std::size_t>(y), rows_ - 1);
    const double s = x - static_cast<double>(i), t = y - static_cast<double>(j);
    const auto between = [&](double Visibility::*part) {
      const double low = (1.0 - s) * (corner(i, j).*part) + s * (corner(i + 1, j).*part);
      const double high = (1.0 - s) * (corner(i, j + 1).*part) + s * (corner(i + 1, j + 1).*part);
      return (1.0 - t) * low + t * high;
    };
    return {between(&Visibility::sky), between(&Visibility::window)};
  }

 private:
  const Visibility& corner(std::size_t i, std::size_t j) const { return values_[j * (columns_ + 1) + i]; }

  std::size_t columns_, rows_;
  std::vector<Visibility> values_;
};

std::uint8_t srgb_byte(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  const double s = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255.0 * s));
}

/// Soft shoulder of the exposure: colours brighter than white keep some of their hue, as in a photograph.
std::array<std::uint8_t, 3> exposed(const Vector3d& linear) {
  std::array<std::uint8_t, 3> rgb{};
  for (int k = 0; k < 3; ++k) {
    const double x = 0.92 * linear[k];
    const double shoulder = x < 0.6 ? x : 0.6 + 0.4 * (1.0 - 1.0 / (1.0 + (x - 0.6) / 0.4));
    rgb[static_cast<std::size_t>(k)] = srgb_byte(shoulder);
  }
  return rgb;
}

Gaussian splat(const Vector3d& place, const Slopes& slopes, double spacing, Random& random) {
  const Vector3d normal = slopes.normal();
  const Vector3d tangent = slopes.along_u.normalized();
  Eigen::Matrix3d R;
  R << tangent, normal.cross(tangent), normal;
  const auto sigma = [&](double side) {
    const double length = std::clamp(side, 0.4 * spacing, 1.8 * spacing);
    return kPatchTangentSigma * length *
           random.uniform(1.0 - kPatchTangentVariation, 1.0 + kPatchTangentVariation);
  };
  const double sigma_u = sigma(slopes.along_u.norm());
  const double sigma_v = sigma(std::abs(slopes.along_v.dot(R.col(1))));
  const double alpha = random.uniform(kPatchOpacityMin, kPatchOpacityMax);
  return {place, Eigen::Quaterniond(R).normalized(), {sigma_u, sigma_v, kPatchNormalSigma * spacing}, alpha};
}

}  // namespace

Vector3d linear_color(unsigned rgb) {
  Vector3d linear;
  for (int k = 0; k < 3; ++k) {
    const double s = static_cast<double>((rgb >> (16U - 8U * static_cast<unsigned>(k))) & 0xffU) / 255.0;
    linear[k] = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  }
  return linear;
}

void append_patch(const PaintedPatch& patch, const SoftLight& light, int object, Random& random,
                  GaussianScene& scene) {
  const double height =
      std::max({length_along_v(patch, 0.0), length_along_v(patch, 0.33), length_along_v(patch, 0.67)});
  const double width =
      std::max({length_along_u(patch, 0.1), length_along_u(patch, 0.5), length_along_u(patch, 0.9)});
  const std::size_t rows = cells(height, patch.spacing);
  const LightGrid grid(patch, light, cells(width, kLightCell * patch.spacing),
                       cells(height, kLightCell * patch.spacing));
  const double dv = 1.0 / static_cast<double>(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const double middle = (static_cast<double>(row) + 0.5) * dv;
    const std::size_t columns = cells(length_along_u(patch, middle), patch.spacing);
    const double du = 1.0 / static_cast<double>(columns);
    for (std::size_t column = 0; column < columns; ++column) {
      const double across = random.uniform(-kSampleJitter, kSampleJitter);
      const double along = random.uniform(-kSampleJitter, kSampleJitter);
      const double u = (static_cast<double>(column) + 0.5 + across) * du;
      const double v = middle + along * dv;
      const Vector3d place = patch.at(u, v);
      if (patch.keeps && !patch.keeps(place)) continue;
      if (light.distance(place, 0.0, object) < -kCovered) continue;
      const Slopes slopes =
          slopes_at(patch, u, v, std::max(du, kLeastParameterStep), std::max(dv, kLeastParameterStep));
      const Paint paint = patch.paint(u, v, place);
      const Vector3d seen = lit(paint.albedo, paint.gloss, slopes.normal(), grid.at(u, v));
      scene.append(splat(place, slopes, patch.spacing, random), exposed(seen));
    }
  }
}

}  // namespace palpate

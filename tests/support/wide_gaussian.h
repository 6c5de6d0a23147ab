/// \file
/// Activation and registration of Gaussians (paper eqs. 2-3) in extended precision, from the numbers of the
/// file on, independently of src/palpate/scene.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include <palpate/geometry/similarity.h>
#include <palpate/scene/gaussian_scene.h>
#include <support/k_oracle.h>

namespace palpate::test {

using Wide = long double;

/// One Gaussian of a file, activated.
struct WideGaussian {
  Vec3<Wide> position{};
  std::array<Wide, 4> q{};  ///< w x y z, not normalised
  Vec3<Wide> sigma{};
  Wide alpha = 0;
};

/// The rotation matrix of a quaternion of any length, column by column.
template <typename Real>
std::array<Vec3<Real>, 3> columns(const std::array<Real, 4>& q) {
  const Real length = square_root(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const Real w = q[0] / length, x = q[1] / length, y = q[2] / length, z = q[3] / length;
  return {Vec3<Real>{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
          Vec3<Real>{2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
          Vec3<Real>{2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}

/// Gaussian i of `scene`; Mip-Splatting's filter is not for here.
inline WideGaussian wide_gaussian(const GaussianScene& scene, std::size_t i) {
  WideGaussian g;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto n = static_cast<int>(k);
    g.position[k] = static_cast<Wide>(scene.origin[n]) + static_cast<Wide>(scene.position[i][n]);
    const auto s = static_cast<Wide>(scene.scale[i][n]);
    g.sigma[k] = scene.scale_encoding == ScaleEncoding::kLog ? std::exp(s) : std::abs(s);
  }
  for (std::size_t k = 0; k < 4; ++k) g.q[k] = scene.rotation[i][static_cast<int>(k)];
  const auto o = static_cast<Wide>(scene.opacity[i]);
  g.alpha = scene.opacity_encoding == OpacityEncoding::kLogit ? 1 / (1 + std::exp(-o)) : o / 255;
  return g;
}

/// Its ellipsoid of `multiple` standard deviations, in the world.
template <typename Real = Wide>
Solid<Real> solid_of(const WideGaussian& g, double multiple, const Similarity& world = {}) {
  const auto& r = world.rotation;
  const auto real = [](const auto&... numbers) { return std::array{static_cast<Real>(numbers)...}; };
  const std::array<Vec3<Real>, 3> R = columns(real(r.w(), r.x(), r.y(), r.z())),
                                  axes = columns(real(g.q[0], g.q[1], g.q[2], g.q[3]));
  const auto turn = [&](const Vec3<Real>& v) { return v[0] * R[0] + v[1] * R[1] + v[2] * R[2]; };
  const auto scale = static_cast<Real>(world.scale);
  Solid<Real> solid;
  solid.center = scale * turn({g.position[0], g.position[1], g.position[2]}) +
                 Vec3<Real>{world.translation.x(), world.translation.y(), world.translation.z()};
  for (std::size_t k = 0; k < 3; ++k)
    solid.axes[k] = (scale * static_cast<Real>(multiple) * static_cast<Real>(g.sigma[k])) * turn(axes[k]);
  return solid;
}

}  // namespace palpate::test

/// \file
/// Conversion between the constant SH term of a Gaussian and its colour.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace palpate {

/// The constant spherical harmonic, 1 / (2 sqrt(pi)).
inline constexpr double kShBand0 = 0.28209479177387814;

/// INRIA's convention: colour = 1/2 + kShBand0 f_dc, clamped to [0, 1], here as an sRGB byte. NaN is
/// black.
inline std::uint8_t color_from_sh(double f_dc) {
  const double value = 0.5 + kShBand0 * f_dc;
  return static_cast<std::uint8_t>(std::lround(255.0 * (value > 0.0 ? std::min(value, 1.0) : 0.0)));
}

/// The constant term whose colour is the sRGB byte `color`.
inline double sh_from_color(std::uint8_t color) { return (color / 255.0 - 0.5) / kShBand0; }

}  // namespace palpate

/// \file
/// Numbers of a binary .ply row, for the writers of scenes.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <string>

#include <palpate/scene/gaussian_scene.h>

namespace palpate {

/// Appends `value` as a little-endian float.
inline void append_float(std::string& out, double value) {
  auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  for (int k = 0; k < 4; ++k, bits >>= 8) out.push_back(static_cast<char>(bits & 0xffU));
}

/// Appends opacity (logit), scale_0..2 (log) and rot_0..3.
inline void append_shape(std::string& out, const Gaussian& g) {
  append_float(out, std::log(g.opacity / (1.0 - g.opacity)));
  for (const double s : g.sigma) append_float(out, std::log(s));
  for (const double q : {g.rotation.w(), g.rotation.x(), g.rotation.y(), g.rotation.z()})
    append_float(out, q);
}

}  // namespace palpate

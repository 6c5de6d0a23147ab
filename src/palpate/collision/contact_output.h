/// \file
/// Parts of a contact that are computed outside the SIMD lanes.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <palpate/collision/contact.h>
#include <palpate/collision/index_layout.h>
#include <palpate/collision/tool_frame.h>

namespace palpate {

/// Computes the contact of one Gaussian by the scalar code of k_function.h, without the fields of its label;
/// returns false if there is none. If double cannot resolve whether they touch, the verdict and K_min are
/// those of exact_k_min().
bool scalar_contact(const GaussianBlock& block, std::size_t lane, const ToolFrame& tool, Contact& contact);

/// The root of the sum of the squares of a Gaussian's semi-axes, see Contact::extent. Unit: [captured units].
inline float extent_of(const GaussianBlock& block, std::size_t lane) {
  const auto length = [&](std::size_t axis) { return block.length_high[axis][lane]; };
  return std::sqrt(length(0) * length(0) + length(1) * length(1) + length(2) * length(2));
}

/// Fields of a contact that depend on the Gaussian only.
struct GaussianLabel {
  std::uint32_t id;
  float extent;  ///< extent_of(). Unit: [captured units].
  double opacity;

  static GaussianLabel of(const GaussianBlock& block, std::size_t lane, float extent) {
    return {block.id[lane], extent,
            static_cast<double>(block.opacity_high[lane]) + static_cast<double>(block.opacity_low[lane])};
  }
};

}  // namespace palpate

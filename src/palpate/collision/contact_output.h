/// \file
/// What of a contact does not come out of lanes.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <palpate/collision/contact.h>
#include <palpate/collision/index_layout.h>
#include <palpate/collision/tool_frame.h>

namespace palpate {

/// The contact of one Gaussian by the scalar code of k_function.h, but for what its label has; false if it is
/// apart. Nearer to touching than double resolves, the verdict is that of exact_k_min(), and K_min with it.
bool scalar_contact(const GaussianBlock& block, std::size_t lane, const ToolFrame& tool, Contact& contact);

/// The root of the sum of the squares of a Gaussian's semi-axes, see Contact::extent. Unit: [captured units].
inline float extent_of(const GaussianBlock& block, std::size_t lane) {
  const auto length = [&](std::size_t axis) { return block.length_high[axis][lane]; };
  return std::sqrt(length(0) * length(0) + length(1) * length(1) + length(2) * length(2));
}

/// What of a contact is the Gaussian's own.
struct GaussianLabel {
  std::uint32_t id;
  float extent;  ///< extent_of() it. Unit: [captured units].
  double opacity;

  static GaussianLabel of(const GaussianBlock& block, std::size_t lane, float extent) {
    return {block.id[lane], extent,
            static_cast<double>(block.opacity_high[lane]) + static_cast<double>(block.opacity_low[lane])};
  }
};

}  // namespace palpate

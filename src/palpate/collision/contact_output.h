/// \file
/// From lanes to contacts in memory: the end of the contact kernel, scalar on every instruction set.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <palpate/collision/contact.h>
#include <palpate/collision/tool_frame.h>
#include <palpate/collision/whitened_pairs.h>

namespace palpate {

/// A Gaussian in the captured frame, relative to the index's origin.
using CapturedSolid = Ellipsoid;

/// The contact of one pair by the scalar code of k_function.h, but for id and opacity; false if the pair is
/// apart.
bool scalar_contact(const CapturedSolid& gaussian, const ToolFrame& tool, Contact& contact);

/// Pairs that touch, by number. One more is written than counted.
template <typename T>
struct TouchingPairs {
  std::size_t size = 0;
  std::array<std::uint32_t, WhitenedPairs<T>::kCapacity + 1> pair;

  /// Those of the first `n` that are open. Without a branch on them, which the processor could not predict.
  TouchingPairs(const WhitenedPairs<T>& pairs, std::size_t n) {
    for (std::size_t i = 0; i < n; i += pairs.kWidth) {
      const std::uint32_t open = pairs.open[i / pairs.kWidth];
      for (std::size_t lane = 0; lane < pairs.kWidth; ++lane) {
        pair[size] = static_cast<std::uint32_t>(i + lane);
        size += open >> lane & 1U;
      }
    }
  }
};

/// Appends the contacts among the first `n` pairs, whose ids are `id`, in their order. Pairs that the lanes
/// left open but not sure go through the scalar code; `solid(pair)` is their CapturedSolid. \param end where
/// to write to in `contacts`, which grows if it must. \returns the end of what was written.
template <typename T, class SolidOf>
std::size_t write_contacts(const WhitenedPairs<T>& pairs, std::size_t n, const std::uint32_t* id,
                           const ToolFrame& tool, const SolidOf& solid, std::size_t end,
                           std::vector<Contact>& contacts) {
  const TouchingPairs<T> touching(pairs, n);
  if (contacts.size() < end + touching.size) contacts.resize(end + touching.size);
  const Eigen::Vector3d& tool_center = tool.world.ellipsoid.center;
  for (std::size_t k = 0; k < touching.size; ++k) {
    const std::size_t pair = touching.pair[k], lane = pair % pairs.kWidth;
    const WhitenedGroup<T>& g = pairs.group(pair);
    const auto vector = [lane](const std::array<typename WhitenedGroup<T>::Lane, 3>& v) {
      return Eigen::Vector3d(v[0][lane], v[1][lane], v[2][lane]);
    };
    Contact& contact = contacts[end];
    contact.id = id[pair];
    contact.opacity = g.opacity[lane];
    if ((pairs.sure[pair / pairs.kWidth] >> lane & 1U) == 0) {
      end += scalar_contact(solid(pair), tool, contact) ? 1 : 0;
      continue;
    }
    contact.k_min = g.k_min[lane];
    contact.lambda = g.lambda[lane];
    contact.center = tool_center + vector(g.center);
    contact.point = tool_center + vector(g.point);
    contact.normal = vector(g.normal);
    contact.depth = g.depth[lane];
    ++end;
  }
  return end;
}

}  // namespace palpate

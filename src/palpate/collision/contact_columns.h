/// \file
/// Contacts of many tools as a structure of arrays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <palpate/collision/contact.h>

namespace palpate {

/// Result of ContactQuery::query_batch(): a structure of arrays, which a remote backend can fill and a
/// program in another language can read without knowing Contact. Vectors are [n, 3] numbers, row-major.
struct ContactColumns {
  /// The contacts of tool i are those from first[i] to before first[i + 1]. Shape: [tools + 1].
  std::vector<std::size_t> first = {0};

  /// \name One row per tool, see ContactSet
  /// @{
  std::vector<std::size_t> candidates, filtered;
  /// @}

  /// \name One row per contact, see Contact
  /// @{
  std::vector<std::uint32_t> id;
  std::vector<double> k_min, lambda, opacity;
  std::vector<Eigen::Vector3d> center, point, normal;
  std::vector<double> depth, extent;
  /// @}

  std::size_t tools() const { return first.size() - 1; }
  std::size_t contacts() const { return id.size(); }
  /// Contact `i`; Contact::part is left at 0.
  Contact contact(std::size_t i) const;

  /// Empties all columns but keeps their memory.
  void clear();
  /// Appends the contacts of further tools, one set per tool, in parallel on the calling thread's oneTBB
  /// arena.
  void append(std::span<const ContactSet> sets);
};

}  // namespace palpate

/// \file
/// The contacts of many tools, as columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <palpate/collision/contact.h>

namespace palpate {

/// What ContactQuery::query_batch() answers with: a structure of arrays, which a machine that answers
/// elsewhere can fill, and a program in another language take, without a look at Contact. Vectors are n x 3
/// numbers, row by row.
struct ContactColumns {
  /// The contacts of tool i are those from first[i] to before first[i + 1]: one number more than tools.
  std::vector<std::size_t> first = {0};

  /// \name A row a tool: see ContactSet
  /// @{
  std::vector<std::size_t> candidates, filtered;
  /// @}

  /// \name A row a contact: see Contact
  /// @{
  std::vector<std::uint32_t> id;
  std::vector<double> k_min, lambda, opacity;
  std::vector<Eigen::Vector3d> center, point, normal;
  std::vector<double> depth, extent;
  /// @}

  std::size_t tools() const { return first.size() - 1; }
  std::size_t contacts() const { return id.size(); }
  /// Row `i`; Contact::part is left at 0.
  Contact contact(std::size_t i) const;

  /// Keeps its memory.
  void clear();
  /// Those of as many tools more, in parallel on the calling thread's oneTBB arena.
  void append(std::span<const ContactSet> sets);
};

}  // namespace palpate

/// \file
/// Permutation table that packs the selected lanes of a mask to the front.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace palpate {

/// Row m lists the set bits of m from the lowest on, then the others: N lanes, 2^N masks.
template <std::size_t N>
constexpr std::array<std::array<std::int32_t, N>, (std::size_t{1} << N)> make_pack_table() {
  std::array<std::array<std::int32_t, N>, (std::size_t{1} << N)> table{};
  for (std::size_t mask = 0; mask < table.size(); ++mask) {
    std::size_t at = 0;
    for (const std::size_t wanted : {std::size_t{1}, std::size_t{0}}) {
      for (std::size_t lane = 0; lane < N; ++lane) {
        if ((mask >> lane & 1U) == wanted) table[mask][at++] = static_cast<std::int32_t>(lane);
      }
    }
  }
  return table;
}

/// For up to eight lanes: 8 KB at most. Wider instruction sets have a compress instruction.
template <std::size_t N>
inline constexpr auto kPackTable = make_pack_table<N>();

}  // namespace palpate

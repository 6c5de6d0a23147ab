/// \file
/// From WhitenedPairs to contacts in memory: scalar, but compiled for every instruction set, since leaving
/// one for another on the way costs more than the work itself.
// clang-format off
#if defined(PALPATE_COLLISION_OUTPUT_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_COLLISION_OUTPUT_LANES_INL_H_
#undef PALPATE_COLLISION_OUTPUT_LANES_INL_H_
#else
#define PALPATE_COLLISION_OUTPUT_LANES_INL_H_
#endif
// clang-format on

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/collision/contact_output.h>
#include <palpate/collision/group_lanes-inl.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Pairs by number.
struct PairList {
  std::size_t size = 0;
  PairBuffer::Lane<std::uint32_t> pair;

  std::span<const std::uint32_t> span() const { return {pair.data(), size}; }
};

/// Those of the first `n` pairs whose bit is set. Without a branch on them, which the processor could not
/// predict.
HWY_INLINE void list_set(const PairBits& bits, std::size_t n, PairList& list) {
  const hn::Rebind<std::uint32_t, DFloat> numbers;
  list.size = 0;
  for (std::size_t i = 0; i < n; i += Floats::width()) {
    const auto mask = mask_of<DFloat, 1>(get_bits<Floats>(bits, i));
    const LanePacker<DFloat> pack(mask);
    const auto pairs = hn::Iota(numbers, static_cast<std::uint32_t>(i));
    pack(Floats(hn::BitCast(DFloat(), pairs)), reinterpret_cast<float*>(&list.pair[list.size]));
    list.size += count_of(mask);
  }
}

/// Appends the contacts among the pairs `touching`, whose Gaussians are in `slot`. Pairs that the lanes left
/// open but not sure go through the scalar code. \param end where to write to in `contacts`, which grows if
/// it must; `label(pair)` is the pair's GaussianLabel. \returns the end of what was written.
template <typename T, class LabelOf>
HWY_INLINE std::size_t write_contacts(const WhitenedPairs<T>& pairs, std::span<const std::uint32_t> touching,
                                      const GaussianSlot* slot, std::span<const GaussianBlock> blocks,
                                      const ToolFrame& tool, const LabelOf& label, std::size_t end,
                                      std::vector<Contact>& contacts) {
  if (contacts.size() < end + touching.size()) contacts.resize(end + touching.size());
  for (const std::uint32_t pair : touching) {
    Contact& contact = contacts[end];
    const GaussianLabel gaussian = label(pair);
    contact.id = gaussian.id;
    contact.part = 0;
    contact.opacity = gaussian.opacity;
    contact.extent = tool.scale * static_cast<double>(gaussian.extent);
    if (!pairs.sure[pair]) {
      end += scalar_contact(blocks[slot[pair].block()], slot[pair].lane(), tool, contact) ? 1 : 0;
      continue;
    }
    const auto row = [&](std::size_t k) -> const std::array<double, 2>& { return pairs.row[k][pair]; };
    contact.k_min = row(0)[0];
    contact.lambda = row(0)[1];
    contact.center = {row(1)[0], row(1)[1], row(2)[0]};
    contact.point = {row(2)[1], row(3)[0], row(3)[1]};
    contact.normal = {row(4)[0], row(4)[1], row(5)[0]};
    contact.depth = row(5)[1];
    ++end;
  }
  return end;
}

}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // once per target

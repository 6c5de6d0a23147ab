/// \file
/// Output of contacts from WhitenedPairs to memory: scalar, but compiled for every instruction set, since
/// switching between instruction sets costs more than the work itself.
// clang-format off
#if defined(PALPATE_COLLISION_OUTPUT_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_COLLISION_OUTPUT_LANES_INL_H_
#undef PALPATE_COLLISION_OUTPUT_LANES_INL_H_
#else
#define PALPATE_COLLISION_OUTPUT_LANES_INL_H_
#endif
// clang-format on

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/collision/contact_output.h>
#include <palpate/collision/group_lanes-inl.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// List of pair indices.
struct PairList {
  std::size_t size = 0;
  PairBuffer::Lane<std::uint32_t> pair;

  std::span<const std::uint32_t> span() const { return {pair.data(), size}; }
};

/// Lists those of the first `n` pairs whose bit is set. Branchless, since the bits are unpredictable.
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

// Pairs of numbers of WhitenedPairs::row are neighbours in a Contact, too.
static_assert(offsetof(Contact, lambda) == offsetof(Contact, k_min) + sizeof(double) &&
              offsetof(Contact, point) == offsetof(Contact, center) + 3 * sizeof(double) &&
              offsetof(Contact, normal) == offsetof(Contact, point) + 3 * sizeof(double) &&
              offsetof(Contact, depth) == offsetof(Contact, normal) + 3 * sizeof(double));

/// Copies both numbers of row `k` of a pair to `to` in one step: number by number, copying a contact would
/// take as long as its certificate.
template <typename T>
HWY_INLINE void copy_row(std::size_t k, const WhitenedPairs<T>& pairs, std::size_t pair, double* to) {
  const hn::CappedTag<double, 2> two;
  const double* from = pairs.row[k][pair].data();
  for (std::size_t i = 0; i < 2; i += hn::Lanes(two)) hn::StoreU(hn::Load(two, from + i), two, to + i);
}

/// Appends the contacts among the pairs `touching`, whose Gaussians are in `slot`. Pairs that are open but
/// not sure go through the scalar code. \param end where to write to in `contacts`, which grows if needed;
/// `label(pair)` is the pair's GaussianLabel. \returns the end of what was written.
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
    copy_row(0, pairs, pair, &contact.k_min);
    copy_row(1, pairs, pair, &contact.center[0]);
    copy_row(2, pairs, pair, &contact.center[2]);
    copy_row(3, pairs, pair, &contact.point[1]);
    copy_row(4, pairs, pair, &contact.normal[0]);
    copy_row(5, pairs, pair, &contact.normal[2]);
    ++end;
  }
  return end;
}

}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // once per target

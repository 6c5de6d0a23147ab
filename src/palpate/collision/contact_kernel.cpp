#include <palpate/collision/contact_kernel.h>

#include <algorithm>
#include <cstddef>
#include <type_traits>

#include <palpate/collision/candidate_sample.h>
#include <palpate/collision/instruction_sets.h>
#include <palpate/collision/pair_buffer.h>
#include <palpate/collision/simd_target.h>
#include <palpate/collision/whitened_pairs.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "palpate/collision/contact_kernel.cpp"
#include <hwy/foreach_target.h>  // before highway.h

#include <hwy/highway.h>

#include <palpate/collision/contact_lanes-inl.h>
#include <palpate/collision/output_lanes-inl.h>
#include <palpate/collision/pair_lanes-inl.h>
#include <palpate/collision/search_lanes-inl.h>
#include <palpate/collision/walk_lanes-inl.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::HWY_NAMESPACE {
namespace {

/// Loads as many floats as L has lanes, aligned or not.
template <class L>
HWY_INLINE L load_as(const float* from) {
  if constexpr (std::is_same_v<L, Doubles>) {
    return L(hn::PromoteTo(DDouble(), hn::LoadU(hn::Rebind<float, DDouble>(), from)));
  } else {
    return L(hn::LoadU(DFloat(), from));
  }
}

/// Loads pairs of the buffer, from i on, as solids; single precision omits the low parts of lengths.
template <class L>
HWY_INLINE Solid<L> load_solid(const PairBuffer& b, std::size_t i) {
  const auto at = [&](const PairBuffer::Lane<float>& lane) HWY_ATTR { return load_as<L>(&lane[i]); };
  const auto length = [&](std::size_t axis) HWY_ATTR {
    if constexpr (std::is_same_v<L, Doubles>) {
      return at(b.length_high[axis]) + at(b.length_low[axis]);
    } else {
      return at(b.length_high[axis]);
    }
  };
  Solid<L> solid;
  solid.center = {at(b.position[0]), at(b.position[1]), at(b.position[2])};
  scaled_rotation(at(b.rotation[0]), at(b.rotation[1]), at(b.rotation[2]), at(b.rotation[3]),
                  Vec3<L>{length(0), length(1), length(2)}, solid.axis);
  return solid;
}

HWY_INLINE Whitened<Doubles> whitened(const Solid<Doubles>& solid, const ToolFrame& tool) {
  return {broadcast<Doubles>(tool.center) - solid.center, solid.axis, tool.W};
}
HWY_INLINE Whitened<Floats> whitened(const Solid<Floats>& solid, const ToolFrame& tool) {
  const Vec3<Floats> offset =
      (broadcast<Floats>(tool.center_high) - solid.center) + broadcast<Floats>(tool.center_low);
  return {offset, solid.axis, tool.W_float};
}

/// Whitens solids and stores them as pairs, from i on.
template <class L>
HWY_INLINE void whiten_into(const Solid<L>& solid, const ToolFrame& tool, PairsOf<L>& pairs, std::size_t i) {
  whitened(solid, tool).put_into(pairs, [&](PairBuffer::Lane<typename L::T>& lane, const L& x) HWY_ATTR {
    store(x, lane, i);
  });
}

/// Memory of the last stages, on the stack.
struct Workspace {
  WhitenedPairs<double> pairs;
  WhitenedPairs<float> singles;
  PairList touching;
};

/// Representation of the pairs that pass the screen.
enum class Kept {
  kPair,      ///< in the buffer, unchanged
  kWhitened,  ///< whitened: in the frame where the tool is the unit sphere
};

/// First part of stage 3: keeps the pairs of `buffer` that the first step of the search does not separate,
/// and stores the t of that step in `singles`, with the whitened pairs if these are kept. Most pairs of a
/// capture end here, so that later stages have no closed lanes.
template <Precision kPrecision, Kept kKept>
HWY_INLINE void screen(PairBuffer& buffer, const ToolFrame& tool, WhitenedPairs<float>& singles) {
  const std::size_t n = buffer.size;
  buffer.size = 0;
  for (std::size_t i = 0; i < n; i += Floats::width()) {
    const Whitened<Floats> seen = whitened(load_solid<Floats>(buffer, i), tool);
    const SearchStep<Floats> next(seen.k, first_t(seen.k), tool.single);
    const auto open = and_not(next.apart, first_lanes<Floats>(n - i));
    const auto squared_length = [&](std::size_t axis) HWY_ATTR {
      const Floats length = load<Floats>(buffer.length_high[axis], i);
      return length * length;
    };
    const Floats extent = sqrt((squared_length(0) + squared_length(1)) + squared_length(2));
    const LanePacker<DFloat> pack(open);
    const std::size_t to = buffer.size;
    // In place: lanes that are overwritten have been read.
    const auto pack_lane = [&](auto& lane) HWY_ATTR {
      pack(Floats(hn::LoadU(DFloat(), reinterpret_cast<const float*>(&lane[i]))),
           reinterpret_cast<float*>(&lane[to]));
    };
    const auto pack_lanes = [&](auto& lanes) HWY_ATTR {
      for (auto& lane : lanes) pack_lane(lane);
    };
    if constexpr (kKept == Kept::kPair) {
      pack_lanes(buffer.position);
      pack_lanes(buffer.length_high);
      if constexpr (kPrecision == Precision::kDouble) pack_lanes(buffer.length_low);
      pack_lanes(buffer.rotation);
    } else {
      seen.put_into(singles,
                    [&](PairBuffer::Lane<float>& lane, const Floats& x) HWY_ATTR { pack(x, &lane[to]); });
    }
    pack_lane(buffer.slot);
    pack(extent, &buffer.extent[to]);
    pack(next.t, &singles.t[to]);
    buffer.size += count_of(open);
  }
}

/// Label of a pair that passed the screen.
HWY_INLINE GaussianLabel label_of(const IndexView& index, const PairBuffer& buffer, std::size_t pair) {
  const GaussianSlot slot = buffer.slot[pair];
  return GaussianLabel::of(index.blocks[slot.block()], slot.lane(), buffer.extent[pair]);
}

/// Stage 4 for `n` pairs with Gaussians `slot`: from `w.singles`, or from `w.pairs` with their t in
/// `w.singles`. \returns the end of what was written, see write_contacts().
template <Precision kPrecision, class LabelOf>
std::size_t append_contacts(Workspace& w, std::size_t n, const GaussianSlot* slot, const IndexView& index,
                            const ToolFrame& tool, const LabelOf& label, int steps, std::size_t end,
                            std::vector<Contact>& contacts) {
  const auto write = [&](const auto& pairs) HWY_ATTR {
    list_set(pairs.open, n, w.touching);
    return write_contacts(pairs, w.touching.span(), slot, index.blocks, tool, label, end, contacts);
  };
  if constexpr (kPrecision == Precision::kSingle) {
    search(w.singles, n, tool.single, steps);
    solve<float, TwoFloats, Floats>(w.singles, n, tool);
    return write(w.singles);
  } else {
    round_coefficients(w.pairs, n, w.singles);
    search(w.singles, n, tool.rounded, steps);
    adopt(w.singles, n, w.pairs);
    solve<double, TwoDoubles, Doubles>(w.pairs, n, tool);
    return write(w.pairs);
  }
}

template <Precision kPrecision>
void find_contacts_in(const IndexView& index, const ToolFrame& tool, QueryLimit limit, ContactSet& result) {
  PairBuffer buffer;
  Workspace w;
  std::size_t end = 0;
  result.filtered = 0;
  result.complete = true;
  const auto flush = [&](PairBuffer& pairs) HWY_ATTR {
    result.filtered += pairs.size;
    if constexpr (kPrecision == Precision::kSingle) {
      screen<kPrecision, Kept::kWhitened>(pairs, tool, w.singles);
    } else {
      screen<kPrecision, Kept::kPair>(pairs, tool, w.singles);
      for (std::size_t i = 0; i < pairs.size; i += Doubles::width())
        whiten_into(load_solid<Doubles>(pairs, i), tool, w.pairs, i);
    }
    const auto label = [&](std::size_t pair) HWY_ATTR { return label_of(index, pairs, pair); };
    end = append_contacts<kPrecision>(w, pairs.size, pairs.slot.data(), index, tool, label, kStepsFromGuess,
                                      end, result.contacts);
    pairs.size = 0;
    result.complete = result.filtered < limit.pairs && end < limit.contacts;
    return result.complete;
  };
  result.candidates = walk<kPrecision>(index, tool, AsTheyAre{}, buffer, flush);
  if (result.complete) {
    flush(buffer);
    result.complete = true;  // the traversal has ended, whatever the last flush returned
  }
  result.contacts.resize(end);
}

void FindContacts(const IndexView& index, const ToolFrame& tool, Precision precision, QueryLimit limit,
                  ContactSet& result) {
  if (precision == Precision::kSingle) {
    find_contacts_in<Precision::kSingle>(index, tool, limit, result);
  } else {
    find_contacts_in<Precision::kDouble>(index, tool, limit, result);
  }
}

/// Array in which a CandidateSet stores its axes.
template <class L>
HWY_INLINE auto& axes_of(CandidateSet& candidates) {
  if constexpr (std::is_same_v<L, Doubles>) {
    return candidates.axes;
  } else {
    return candidates.rounded_axes;
  }
}

/// Appends the pairs of a screened buffer to `candidates`. \pre they fit.
template <class L>
void append_candidates(const IndexView& index, const PairBuffer& buffer, const WhitenedPairs<float>& singles,
                       CandidateSet& candidates) {
  const std::size_t first = candidates.size, n = buffer.size;
  for (std::size_t i = 0; i < n; i += L::width()) {
    const Solid<L> solid = load_solid<L>(buffer, i);
    for (std::size_t k = 0; k < 3; ++k) {
      const L* axis = &solid.axis[k].x;
      for (std::size_t c = 0; c < 3; ++c)
        hn::StoreU(axis[c].v[0], L::d(), &axes_of<L>(candidates)[3 * k + c][first + i]);
    }
  }
  for (std::size_t k = 0; k < 3; ++k)
    std::copy_n(buffer.position[k].begin(), n, &candidates.center[k][first]);
  std::copy_n(singles.t.begin(), n, &candidates.t[first]);
  std::copy_n(buffer.slot.begin(), n, &candidates.slot[first]);
  for (std::size_t i = 0; i < n; ++i) {
    candidates.label[first + i] = label_of(index, buffer, i);
  }
  candidates.size += n;
}

/// Policy for too many candidates: keep none.
struct AllOrNone {
  static void thin(PairBuffer&, const CandidateSet&) {}
  static bool make_room(CandidateSet&) { return false; }
};

/// Policy for too many candidates: keep a sample.
struct Sampled {
  static void thin(PairBuffer& pairs, const CandidateSet& candidates) {
    if (candidates.grain > 0.0F) sample(pairs, candidates.grain);
  }
  static bool make_room(CandidateSet& candidates) {
    coarsen(candidates);
    return true;
  }
};

/// Continues the traversal pending in `candidates`, through `most` Gaussians and a few more.
template <Precision kPrecision, class L, class Size, class Crowd>
bool find_candidates_in(const IndexView& index, const ToolFrame& tool, const Size& size, const Crowd& crowd,
                        std::size_t most, CandidateSet& candidates) {
  PairBuffer buffer;
  WhitenedPairs<float> singles;
  bool fits = true;
  candidates.passed = 0;
  const auto flush = [&](PairBuffer& pairs) HWY_ATTR {
    candidates.passed += pairs.size;
    crowd.thin(pairs, candidates);
    screen<kPrecision, Kept::kPair>(pairs, tool, singles);
    fits = fits && (candidates.size + pairs.size <= candidates.capacity || crowd.make_room(candidates));
    if (fits) append_candidates<L>(index, pairs, singles, candidates);
    pairs.size = 0;
    return fits;
  };
  Pending pending;
  pending.node_count = candidates.ahead_count;
  std::copy_n(candidates.ahead.begin(), candidates.ahead_count, pending.nodes);
  candidates.walked = walk_on<kPrecision>(index, tool, size, most, pending, buffer, flush);
  candidates.ahead_count = pending.node_count;
  std::copy_n(pending.nodes, pending.node_count, candidates.ahead.begin());
  if (fits) flush(buffer);
  if (!fits) candidates.size = 0;
  return fits;
}

bool FindCandidates(const IndexView& index, const ToolFrame& tool, Precision precision,
                    CandidateSet& candidates) {
  return precision == Precision::kSingle ? find_candidates_in<Precision::kSingle, Floats>(
                                               index, tool, AsTheyAre{}, AllOrNone(), kAllPairs, candidates)
                                         : find_candidates_in<Precision::kDouble, Doubles>(
                                               index, tool, AsTheyAre{}, AllOrNone(), kAllPairs, candidates);
}

bool FindMagnified(const IndexView& index, const ToolFrame& tool, float times, std::size_t most,
                   CandidateSet& candidates) {
  find_candidates_in<Precision::kSingle, Floats>(index, tool, Magnified{times}, Sampled(), most, candidates);
  if (candidates.ahead_count != 0) return false;
  // Includes those added with the last change of the grain.
  if (candidates.grain > 0.0F) sample(candidates);
  return true;
}

/// Loads candidates from i on as solids.
template <class L>
HWY_INLINE Solid<L> load_candidates(CandidateSet& c, std::size_t i) {
  const auto center = [&](std::size_t k) HWY_ATTR { return load_as<L>(&c.center[k][i]); };
  const auto axis = [&](std::size_t k) HWY_ATTR { return L(hn::LoadU(L::d(), &axes_of<L>(c)[k][i])); };
  Solid<L> solid;
  solid.center = {center(0), center(1), center(2)};
  for (std::size_t k = 0; k < 3; ++k) solid.axis[k] = {axis(3 * k), axis(3 * k + 1), axis(3 * k + 2)};
  return solid;
}

template <Precision kPrecision, class L>
void contacts_among_in(CandidateSet& candidates, const IndexView& index, const ToolFrame& tool,
                       PairsOf<L>& pairs, Workspace& w, QueryLimit limit, ContactSet& result) {
  std::size_t end = 0, first = 0;
  const std::size_t last = std::min(limit.pairs, candidates.size);
  for (; first < last && end < limit.contacts; first += PairBuffer::kCapacity) {
    const std::size_t n = std::min(PairBuffer::kCapacity, candidates.size - first);
    for (std::size_t i = 0; i < n; i += L::width())
      whiten_into(load_candidates<L>(candidates, first + i), tool, pairs, i);
    std::copy_n(&candidates.t[first], n, w.singles.t.begin());
    const auto label = [&](std::size_t pair) HWY_ATTR { return candidates.label[first + pair]; };
    end = append_contacts<kPrecision>(w, n, &candidates.slot[first], index, tool, label, kStepsFromLast, end,
                                      result.contacts);
    std::copy_n(w.singles.t.begin(), n, &candidates.t[first]);
  }
  result.complete = first >= candidates.size;
  result.contacts.resize(end);
}

void ContactsAmong(CandidateSet& candidates, const IndexView& index, const ToolFrame& tool,
                   Precision precision, QueryLimit limit, ContactSet& result) {
  Workspace w;
  if (precision == Precision::kSingle) {
    contacts_among_in<Precision::kSingle, Floats>(candidates, index, tool, w.singles, w, limit, result);
  } else {
    contacts_among_in<Precision::kDouble, Doubles>(candidates, index, tool, w.pairs, w, limit, result);
  }
}

}  // namespace
}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate {
namespace {

HWY_EXPORT(FindContacts);
HWY_EXPORT(FindCandidates);
HWY_EXPORT(FindMagnified);
HWY_EXPORT(ContactsAmong);

}  // namespace

void find_contacts(const IndexView& index, const ToolFrame& tool, Precision precision, QueryLimit limit,
                   ContactSet& result) {
  HWY_DYNAMIC_DISPATCH(FindContacts)(index, tool, precision, limit, result);
}

CandidateSet::CandidateSet(std::size_t most) : capacity(most) {
  const std::size_t room = most + kSlack;
  for (auto& lane : center) lane.resize(room);
  for (auto& lane : axes) lane.resize(room);
  for (auto& lane : rounded_axes) lane.resize(room);
  t.resize(room);
  slot.resize(room);
  label.resize(room);
}

bool find_candidates(const IndexView& index, const ToolFrame& tool, Precision precision,
                     CandidateSet& candidates) {
  begin_search(index, 0.0F, candidates);
  return HWY_DYNAMIC_DISPATCH(FindCandidates)(index, tool, precision, candidates);
}

bool find_magnified(const IndexView& index, const ToolFrame& tool, float times, std::size_t most,
                    CandidateSet& candidates) {
  return HWY_DYNAMIC_DISPATCH(FindMagnified)(index, tool, times, most, candidates);
}

void begin_search(const IndexView& index, float grain, CandidateSet& candidates) {
  candidates.size = candidates.walked = 0;
  candidates.grain = grain;
  candidates.ahead_count = index.nodes.empty() ? 0 : 1;
  candidates.ahead[0] = 0;  // the root
}

void contacts_among(CandidateSet& candidates, const IndexView& index, const ToolFrame& tool,
                    Precision precision, QueryLimit limit, ContactSet& result) {
  result.candidates = candidates.walked;
  result.filtered = candidates.size;
  HWY_DYNAMIC_DISPATCH(ContactsAmong)(candidates, index, tool, precision, limit, result);
}

namespace {

/// Targets that this build contains and the processor supports, as Highway's bits; queried once, since a
/// choice hides the others. Includes the target of the whole program, which Highway omits for NEON without
/// AES.
std::int64_t usable_targets() {
  static const std::int64_t usable = (hwy::SupportedTargets() | HWY_STATIC_TARGET) & HWY_TARGETS;
  return usable;
}

}  // namespace

std::vector<std::string> simd_targets() {
  std::vector<std::string> names;
  for (std::int64_t rest = usable_targets(); rest != 0; rest &= rest - 1) {
    names.emplace_back(hwy::TargetName(rest & -rest));  // the lowest bit is the best target
  }
  return names;
}

void use_simd_target(std::string_view name) {
  std::int64_t chosen = 0;  // no restriction
  for (std::int64_t rest = usable_targets(); rest != 0; rest &= rest - 1) {
    if (name == hwy::TargetName(rest & -rest)) chosen = rest & -rest;
  }
  hwy::SetSupportedTargetsForTest(chosen);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace palpate
#endif  // HWY_ONCE

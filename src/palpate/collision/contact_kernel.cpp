#include <palpate/collision/contact_kernel.h>

#include <algorithm>
#include <cstddef>
#include <type_traits>

#include <palpate/collision/contact_output.h>
#include <palpate/collision/pair_buffer.h>
#include <palpate/collision/simd_target.h>
#include <palpate/collision/whitened_pairs.h>

// Instruction sets: AVX-512 ("AVX3"), AVX2, SSE4, NEON, and the portable baseline, one lane of plain C++.
// Left out is what differs from its neighbour only in instructions that are not used here, and vectors whose
// length is not known when compiling.
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE_256 | HWY_SVE2 | HWY_SVE2_128 | HWY_RVV | HWY_WASM_EMU256)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "palpate/collision/contact_kernel.cpp"
#include <hwy/foreach_target.h>  // before highway.h

#include <hwy/highway.h>

#include <palpate/collision/contact_lanes-inl.h>
#include <palpate/collision/pair_lanes-inl.h>
#include <palpate/collision/search_lanes-inl.h>
#include <palpate/collision/walk_lanes-inl.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::HWY_NAMESPACE {
namespace {

/// Pairs of the buffer, from i on, as solids; in single precision the smaller parts of lengths are left out.
Floats load_lane(const PairBuffer::Lane<float>& lane, std::size_t i, Floats) {
  return Floats(hn::LoadU(DFloat(), &lane[i]));
}
Doubles load_lane(const PairBuffer::Lane<float>& lane, std::size_t i, Doubles) {
  return Doubles(hn::PromoteTo(DDouble(), hn::LoadU(hn::Rebind<float, DDouble>(), &lane[i])));
}

template <class L>
Solid<L> load_solid(const PairBuffer& b, std::size_t i) {
  const auto at = [&](const PairBuffer::Lane<float>& lane) HWY_ATTR { return load_lane(lane, i, L()); };
  const auto sum = [&](const PairBuffer::Lane<float>& high, const PairBuffer::Lane<float>& low) HWY_ATTR {
    if constexpr (std::is_same_v<L, Doubles>) {
      return at(high) + at(low);
    } else {
      return at(high);
    }
  };
  Solid<L> solid;
  solid.center = {at(b.position[0]), at(b.position[1]), at(b.position[2])};
  scaled_rotation(at(b.rotation[0]), at(b.rotation[1]), at(b.rotation[2]), at(b.rotation[3]),
                  Vec3<L>{sum(b.length_high[0], b.length_low[0]), sum(b.length_high[1], b.length_low[1]),
                          sum(b.length_high[2], b.length_low[2])},
                  solid.axis);
  solid.opacity = sum(b.opacity_high, b.opacity_low);
  return solid;
}

/// From the centre of the Gaussian to that of the tool.
Vec3<Doubles> offset_to(const ToolFrame& tool, const Vec3<Doubles>& center) {
  return broadcast<Doubles>(tool.center) - center;
}
Vec3<Floats> offset_to(const ToolFrame& tool, const Vec3<Floats>& center) {
  return (broadcast<Floats>(tool.center_high) - center) + broadcast<Floats>(tool.center_low);
}

void whiten_into(const Solid<Doubles>& solid, const ToolFrame& tool, WhitenedPairs<double>& pairs,
                 std::size_t i) {
  whiten(offset_to(tool, solid.center), solid.axis, solid.opacity, tool.W, pairs, i);
}
void whiten_into(const Solid<Floats>& solid, const ToolFrame& tool, WhitenedPairs<float>& pairs,
                 std::size_t i) {
  whiten(offset_to(tool, solid.center), solid.axis, solid.opacity, tool.W_float, pairs, i);
}

/// What the last stages work with: some 60 KB, on the stack.
struct Workspace {
  WhitenedPairs<double> pairs;
  WhitenedPairs<float> singles;
};

/// A pair of the buffer in double, for the scalar code.
CapturedSolid solid_of(const PairBuffer& b, std::size_t i) {
  const auto sum = [](float high, float low) { return static_cast<double>(high) + static_cast<double>(low); };
  const Eigen::Quaterniond q(b.rotation[0][i], b.rotation[1][i], b.rotation[2][i], b.rotation[3][i]);
  const Eigen::Vector3d lengths(sum(b.length_high[0][i], b.length_low[0][i]),
                                sum(b.length_high[1][i], b.length_low[1][i]),
                                sum(b.length_high[2][i], b.length_low[2][i]));
  return {{b.position[0][i], b.position[1][i], b.position[2][i]},
          q.normalized().toRotationMatrix() * lengths.asDiagonal()};
}

/// Stages 3 and 4 for the pairs of a buffer. \returns the end of what was written, see write_contacts().
std::size_t append_contacts(Workspace& w, const PairBuffer& buffer, const ToolFrame& tool,
                            Precision precision, std::size_t end, std::vector<Contact>& contacts) {
  const std::size_t n = buffer.size;
  const auto solid = [&](std::size_t pair) { return solid_of(buffer, pair); };
  if (precision == Precision::kSingle) {
    for (std::size_t i = 0; i < n; i += Floats::width())
      whiten_into(load_solid<Floats>(buffer, i), tool, w.singles, i);
    guess(w.singles, n);
    search(w.singles, n, tool.single, kStepsFromGuess);
    solve<float, TwoFloats, Floats>(w.singles, n, tool);
    return write_contacts(w.singles, n, buffer.id.data(), tool, solid, end, contacts);
  }
  for (std::size_t i = 0; i < n; i += Doubles::width())
    whiten_into(load_solid<Doubles>(buffer, i), tool, w.pairs, i);
  round_coefficients(w.pairs, n, w.singles);
  guess(w.singles, n);
  search(w.singles, n, kRoundedOnce, kStepsFromGuess);
  adopt(w.singles, n, w.pairs);
  solve<double, TwoDoubles, Doubles>(w.pairs, n, tool);
  return write_contacts(w.pairs, n, buffer.id.data(), tool, solid, end, contacts);
}

void FindContacts(const IndexView& index, const ToolFrame& tool, Precision precision, ContactSet& result) {
  PairBuffer buffer;
  Workspace w;
  std::size_t end = 0;
  result.filtered = 0;
  const auto flush = [&](PairBuffer& pairs) HWY_ATTR {
    end = append_contacts(w, pairs, tool, precision, end, result.contacts);
    result.filtered += pairs.size;
    pairs.size = 0;
  };
  result.candidates = walk(index, tool, buffer, flush);
  flush(buffer);
  result.contacts.resize(end);
}

/// Stages 2 and 3 for the pairs of a buffer: appends to `candidates` those that are not certainly apart. \pre
/// they fit.
void append_candidates(Workspace& w, const PairBuffer& buffer, const ToolFrame& tool,
                       CandidateSet& candidates) {
  const std::size_t first = candidates.size, n = buffer.size;
  const hn::Rebind<float, DDouble> half;
  for (std::size_t i = 0; i < n; i += Doubles::width()) {
    const Solid<Doubles> solid = load_solid<Doubles>(buffer, i);
    const std::size_t to = first + i;
    for (std::size_t k = 0; k < 3; ++k) {
      const Doubles* axis = &solid.axis[k].x;
      for (std::size_t c = 0; c < 3; ++c) {
        hn::StoreU(axis[c].v[0], DDouble(), &candidates.axes[3 * k + c][to]);
        hn::StoreU(hn::DemoteTo(half, axis[c].v[0]), half, &candidates.rounded_axes[3 * k + c][to]);
      }
    }
    hn::StoreU(solid.opacity.v[0], DDouble(), &candidates.opacity[to]);
    hn::StoreU(hn::DemoteTo(half, solid.opacity.v[0]), half, &candidates.rounded_opacity[to]);
    whiten_into(solid, tool, w.pairs, i);
  }
  for (std::size_t k = 0; k < 3; ++k)
    std::copy_n(buffer.position[k].begin(), n, &candidates.center[k][first]);
  round_coefficients(w.pairs, n, w.singles);
  guess(w.singles, n);
  search(w.singles, n, kRoundedOnce, kStepsFromGuess);
  for (std::size_t i = 0; i < n; ++i) {
    if (!w.singles.is_open(i)) continue;
    candidates.move(first + i, candidates.size);
    candidates.t[candidates.size] = w.singles.group(i).t[i % w.singles.kWidth];
    candidates.id[candidates.size++] = buffer.id[i];
  }
}

bool FindCandidates(const IndexView& index, const ToolFrame& tool, CandidateSet& candidates) {
  PairBuffer buffer;
  Workspace w;
  bool fits = true;
  candidates.size = 0;
  const auto flush = [&](PairBuffer& pairs) HWY_ATTR {
    fits = fits && candidates.size + pairs.size <= CandidateSet::kCapacity;
    if (fits) append_candidates(w, pairs, tool, candidates);
    pairs.size = 0;
  };
  candidates.walked = walk(index, tool, buffer, flush);
  flush(buffer);
  if (!fits) candidates.size = 0;
  return fits;
}

/// Candidates from i on, as solids.
void load_candidates(const CandidateSet& c, std::size_t i, Solid<Doubles>& solid) {
  const auto center = [&](std::size_t k) HWY_ATTR {
    return Doubles(hn::PromoteTo(DDouble(), hn::LoadU(hn::Rebind<float, DDouble>(), &c.center[k][i])));
  };
  const auto axis = [&](std::size_t k) HWY_ATTR { return Doubles(hn::LoadU(DDouble(), &c.axes[k][i])); };
  solid.center = {center(0), center(1), center(2)};
  for (std::size_t k = 0; k < 3; ++k) solid.axis[k] = {axis(3 * k), axis(3 * k + 1), axis(3 * k + 2)};
  solid.opacity = Doubles(hn::LoadU(DDouble(), &c.opacity[i]));
}
void load_candidates(const CandidateSet& c, std::size_t i, Solid<Floats>& solid) {
  const auto center = [&](std::size_t k) HWY_ATTR { return Floats(hn::LoadU(DFloat(), &c.center[k][i])); };
  const auto axis = [&](std::size_t k)
                        HWY_ATTR { return Floats(hn::LoadU(DFloat(), &c.rounded_axes[k][i])); };
  solid.center = {center(0), center(1), center(2)};
  for (std::size_t k = 0; k < 3; ++k) solid.axis[k] = {axis(3 * k), axis(3 * k + 1), axis(3 * k + 2)};
  solid.opacity = Floats(hn::LoadU(DFloat(), &c.rounded_opacity[i]));
}

/// A candidate, for the scalar code.
CapturedSolid solid_of(const CandidateSet& c, std::size_t i) {
  CapturedSolid solid;
  for (std::size_t row = 0; row < 3; ++row) {
    const auto r = static_cast<int>(row);
    solid.center[r] = c.center[row][i];
    for (int column = 0; column < 3; ++column)
      solid.axes(r, column) = c.axes[3 * static_cast<std::size_t>(column) + row][i];
  }
  return solid;
}

template <class L>
void whiten_candidates(const CandidateSet& candidates, std::size_t first, std::size_t n,
                       const ToolFrame& tool, PairsOf<L>& pairs) {
  for (std::size_t i = 0; i < n; i += L::width()) {
    Solid<L> solid;
    load_candidates(candidates, first + i, solid);
    whiten_into(solid, tool, pairs, i);
  }
}

void ContactsAmong(CandidateSet& candidates, const ToolFrame& tool, Precision precision, ContactSet& result) {
  Workspace w;
  std::size_t end = 0;
  for (std::size_t first = 0; first < candidates.size; first += PairBuffer::kCapacity) {
    const std::size_t n = std::min(PairBuffer::kCapacity, candidates.size - first);
    const std::uint32_t* id = &candidates.id[first];
    const auto solid = [&](std::size_t pair) { return solid_of(candidates, first + pair); };
    const auto each_group = [&](const auto& visit) {
      for (std::size_t i = 0; i < n; i += kIndexWidth)
        visit(&candidates.t[first + i], w.singles.group(i).t.data());
    };
    each_group([](const float* from, float* to) { std::copy_n(from, kIndexWidth, to); });
    if (precision == Precision::kSingle) {
      whiten_candidates<Floats>(candidates, first, n, tool, w.singles);
      search(w.singles, n, tool.single, kStepsFromLast);
      solve<float, TwoFloats, Floats>(w.singles, n, tool);
      end = write_contacts(w.singles, n, id, tool, solid, end, result.contacts);
    } else {
      whiten_candidates<Doubles>(candidates, first, n, tool, w.pairs);
      round_coefficients(w.pairs, n, w.singles);
      search(w.singles, n, kRoundedOnce, kStepsFromLast);
      adopt(w.singles, n, w.pairs);
      solve<double, TwoDoubles, Doubles>(w.pairs, n, tool);
      end = write_contacts(w.pairs, n, id, tool, solid, end, result.contacts);
    }
    each_group([](float* to, const float* from) { std::copy_n(from, kIndexWidth, to); });
  }
  result.contacts.resize(end);
}

}  // namespace
}  // namespace palpate::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate {
namespace {

HWY_EXPORT(FindContacts);
HWY_EXPORT(FindCandidates);
HWY_EXPORT(ContactsAmong);

}  // namespace

void find_contacts(const IndexView& index, const ToolFrame& tool, Precision precision, ContactSet& result) {
  HWY_DYNAMIC_DISPATCH(FindContacts)(index, tool, precision, result);
}

bool find_candidates(const IndexView& index, const ToolFrame& tool, CandidateSet& candidates) {
  return HWY_DYNAMIC_DISPATCH(FindCandidates)(index, tool, candidates);
}

void contacts_among(CandidateSet& candidates, const ToolFrame& tool, Precision precision,
                    ContactSet& result) {
  result.candidates = candidates.walked;
  result.filtered = candidates.size;
  HWY_DYNAMIC_DISPATCH(ContactsAmong)(candidates, tool, precision, result);
}

namespace {

/// What this build has and the processor runs, as Highway's bits; asked once, as a choice hides the others.
std::int64_t usable_targets() {
  static const std::int64_t usable = hwy::SupportedTargets() & HWY_TARGETS;
  return usable;
}

}  // namespace

std::vector<std::string> simd_targets() {
  std::vector<std::string> names;
  for (std::int64_t rest = usable_targets(); rest != 0; rest &= rest - 1) {
    names.emplace_back(hwy::TargetName(rest & -rest));  // the lowest bit is the best
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

#include <palpate/collision/candidate_sample.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace palpate {
namespace {

/// The first grain, in median extents, and the ratio of successive grains.
constexpr float kFirstGrain = 0.5F, kCoarser = 1.25F;

/// Multiples of the golden ratio by position in the index: every fraction of neighbours is evenly spread.
float lot_of(GaussianSlot slot) {
  constexpr std::uint32_t kGolden = 2654435769U;
  return static_cast<float>(slot.number * kGolden) * 0x1p-32F;
}

bool is_in_sample(GaussianSlot slot, float extent, float grain) {
  const float share = extent / grain;
  return share >= 1.0F || lot_of(slot) < share * share;
}

float median_extent(const CandidateSet& candidates) {
  std::array<float, CandidateSet::kCapacity> extents;
  const std::span<float> all(extents.data(), candidates.size);
  std::ranges::transform(std::span(candidates.label.data(), candidates.size), all.begin(),
                         &GaussianLabel::extent);
  const auto middle = all.begin() + std::ssize(all) / 2;
  std::ranges::nth_element(all, middle);
  return *middle;
}

void move(CandidateSet& c, std::size_t from, std::size_t to) {
  for (auto& lane : c.center) lane[to] = lane[from];
  for (auto& lane : c.rounded_axes) lane[to] = lane[from];
  c.t[to] = c.t[from];
  c.slot[to] = c.slot[from];
  c.label[to] = c.label[from];
}

void move(PairBuffer& pairs, std::size_t from, std::size_t to) {
  for (auto& lane : pairs.position) lane[to] = lane[from];
  for (auto& lane : pairs.length_high) lane[to] = lane[from];
  for (auto& lane : pairs.rotation) lane[to] = lane[from];
  pairs.slot[to] = pairs.slot[from];
}

/// \param extent_of returns the extent of Gaussian i
template <class Gaussians, class ExtentOf>
void sample_by(Gaussians& gaussians, float grain, const ExtentOf& extent_of) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < gaussians.size; ++i) {
    if (is_in_sample(gaussians.slot[i], extent_of(i), grain)) move(gaussians, i, kept++);
  }
  gaussians.size = kept;
}

}  // namespace

void sample(PairBuffer& pairs, float grain) {
  sample_by(pairs, grain, [&](std::size_t i) {
    const auto length = [&](std::size_t axis) { return pairs.length_high[axis][i]; };
    return std::sqrt(length(0) * length(0) + length(1) * length(1) + length(2) * length(2));
  });
}

void sample(CandidateSet& candidates) {
  sample_by(candidates, candidates.grain, [&](std::size_t i) { return candidates.label[i].extent; });
}

void coarsen(CandidateSet& candidates) {
  if (candidates.grain == 0.0F)
    candidates.grain = std::max(kFirstGrain * median_extent(candidates), std::numeric_limits<float>::min());
  // Leaves room for more.
  const std::size_t full = candidates.capacity * 3 / 4;
  while (candidates.size > full) {
    candidates.grain *= kCoarser;
    sample(candidates);
  }
}

}  // namespace palpate

/// \file
/// Contact kernel: the contact query, compiled for every instruction set and dispatched to the best at run
/// time. Internal to collision/; use SceneIndex and ContactTracker.
///
/// A query has four stages. Each is conservative: it may keep too many pairs, but never drops a contact.
///
///   1. walk      the boxes of the wide tree against the tool's box;
///   2. cull      a block's bounding spheres against the tool, where the tool is the unit sphere;
///   3. search    K in single precision: below zero beyond its rounding, the pair is apart; else near its
///                minimum;
///   4. contact   the minimum of K, certified, and what follows from it; by the scalar code, in double or
///                more, where that is too near to touching to tell.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <palpate/base/aligned_vector.h>
#include <palpate/collision/contact.h>
#include <palpate/collision/contact_output.h>
#include <palpate/collision/index_layout.h>
#include <palpate/collision/pair_buffer.h>
#include <palpate/collision/tool_frame.h>

namespace palpate {

/// Candidates: the Gaussians near a tool, activated, as a structure of arrays. Captured frame, relative to
/// the index's origin. The capacity is fixed at construction, so that refilling allocates nothing.
struct CandidateSet {
  /// \param most capacity, from kLeastCapacity to kCapacity; a set takes 150 bytes for each
  explicit CandidateSet(std::size_t most = kCapacity);

  /// Twelve times the contacts of the most crowded pose of the seal under the default tool.
  static constexpr std::size_t kCapacity = 4096;
  /// A quarter of it, which coarsen() frees, holds a PairBuffer.
  static constexpr std::size_t kLeastCapacity = 1024;
  static_assert(kLeastCapacity / 4 >= PairBuffer::kCapacity);
  static constexpr std::size_t kSlack = kIndexWidth;  ///< padding for whole-vector stores at the end

  template <typename T>
  using Array = AlignedVector<T>;

  std::size_t capacity;
  std::size_t size = 0;
  std::size_t walked = 0;       ///< ContactSet::candidates of the last call that searched
  std::size_t passed = 0;       ///< of these, those whose bounding spheres overlap the tool
  std::size_t ahead_count = 0;  ///< pending nodes of an incremental search
  std::array<std::uint32_t, kMaxIndexStack> ahead;
  std::array<Array<float>, 3> center;  ///< as stored in the file
  /// The three semi-axis vectors k sigma r, consecutively: in double for Precision::kDouble, in single for
  /// kSingle.
  std::array<Array<double>, 9> axes;
  std::array<Array<float>, 9> rounded_axes;
  Array<float> t;  ///< lambda / (1 - lambda) at the last known minimum of K
  Array<GaussianSlot> slot;
  Array<GaussianLabel> label;
  /// Of find_magnified(): Gaussians of an extent below this are sampled. Unit: [captured units].
  float grain = 0.0F;
};

/// Finds all contacts of `tool`, in the order of the blocks; with a limit, those found up to the end of the
/// batch in which `limit` is reached. Allocates only if they exceed the capacity of `result`.
void find_contacts(const IndexView& index, const ToolFrame& tool, Precision precision, QueryLimit limit,
                   ContactSet& result);

/// Finds a superset of the Gaussians that `tool` overlaps; returns false if they exceed the capacity,
/// `candidates` then being empty.
bool find_candidates(const IndexView& index, const ToolFrame& tool, Precision precision,
                     CandidateSet& candidates);

/// As find_candidates in single precision, of Gaussians whose ellipsoids are enlarged `times` times, times >=
/// 1; so are their axes in `candidates`. Not for contacts_among().
///
/// If they exceed the capacity, a sample of the smaller ones represents all: of those with extent e below a
/// grain (the smallest grain that fits, or that of begin_search()), a share (e / grain)^2 is kept, so that
/// they occlude as much if each is drawn grain / e times as large (as in stochastic simplification: Cook et
/// al. 2007). Selection depends on the position in the index, where neighbours follow each other, and on the
/// grain, not on the tool; the sample of a larger grain is a subset of that of a smaller one.
///
/// Continues where the last call with the same arguments stopped, or starts after begin_search(), and visits
/// `most` Gaussians and a few more. \returns true when the search is complete.
bool find_magnified(const IndexView& index, const ToolFrame& tool, float times, std::size_t most,
                    CandidateSet& candidates);

/// Empties `candidates` and restarts the search at the root of `index`. \param grain initial sampling grain,
/// 0 to keep all
void begin_search(const IndexView& index, float grain, CandidateSet& candidates);

/// As find_contacts, but only among `candidates`, which were found with the same precision; updates their t.
void contacts_among(CandidateSet& candidates, const IndexView& index, const ToolFrame& tool,
                    Precision precision, QueryLimit limit, ContactSet& result);

}  // namespace palpate

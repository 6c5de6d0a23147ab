/// \file
/// The contact query, compiled for every instruction set and dispatched to the best at run time. Internal to
/// collision/: SceneIndex and ContactTracker are the way in.
///
/// A query goes through four stages. Each may keep too much, none drops a contact:
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

/// Gaussians near a tool, activated, as a structure of arrays. Captured frame, relative to the index's
/// origin. Its capacity is fixed when it is made, so that refilling it takes nothing from the heap.
struct CandidateSet {
  /// \param most from kLeastCapacity to kCapacity; a set takes 150 bytes for each
  explicit CandidateSet(std::size_t most = kCapacity);

  /// Twelve times the contacts of the most crowded pose of the seal under the default tool.
  static constexpr std::size_t kCapacity = 4096;
  /// A quarter of it, which coarsen() leaves free, holds a PairBuffer.
  static constexpr std::size_t kLeastCapacity = 1024;
  static_assert(kLeastCapacity / 4 >= PairBuffer::kCapacity);
  static constexpr std::size_t kSlack = kIndexWidth;  ///< that whole vectors may be stored at the end

  template <typename T>
  using Array = AlignedVector<T>;

  std::size_t capacity;
  std::size_t size = 0;
  std::size_t walked = 0;       ///< ContactSet::candidates of the last call that searched
  std::size_t passed = 0;       ///< those of them whose bounding spheres met the tool
  std::size_t ahead_count = 0;  ///< nodes of the index that a search in portions has still ahead
  std::array<std::uint32_t, kMaxIndexStack> ahead;
  std::array<Array<float>, 3> center;  ///< as their file has it
  /// The three semi-axis vectors k sigma r, one after the other: for Precision::kDouble, or for kSingle.
  std::array<Array<double>, 9> axes;
  std::array<Array<float>, 9> rounded_axes;
  Array<float> t;  ///< lambda / (1 - lambda) where K was least when last seen
  Array<GaussianSlot> slot;
  Array<GaussianLabel> label;
  /// Of find_magnified(): Gaussians of less extent than this are a sample. Unit: [captured units].
  float grain = 0.0F;
};

/// All contacts of `tool`, into `result`, in the order of the blocks; or those that are found up to the
/// buffer in which `limit` is reached. Allocates only if they do not fit its capacity.
void find_contacts(const IndexView& index, const ToolFrame& tool, Precision precision, QueryLimit limit,
                   ContactSet& result);

/// A superset of the Gaussians that `tool` overlaps; false if they do not fit, `candidates` then being empty.
bool find_candidates(const IndexView& index, const ToolFrame& tool, Precision precision,
                     CandidateSet& candidates);

/// As find_candidates in single precision, of Gaussians whose ellipsoids are `times` as large, times >= 1: so
/// are their axes in `candidates`. Not for contacts_among().
///
/// Where they do not fit, a sample of the smaller ones stands for them: of those whose extent e is below a
/// grain, as small a grain as fits or what begin_search() was told, a share (e / grain)^2, so that they hide
/// as much where each is drawn grain / e times as large (as for stochastic simplification: Cook et al. 2007).
/// Which they are depends on their place in the index, where neighbours follow each other, and on the grain,
/// not on the tool; of a larger grain, they are among those of a smaller one.
///
/// Goes on where the last call with the same arguments has stopped, or begins after begin_search(), and goes
/// through `most` Gaussians and a few besides. \returns true once it has been through all.
bool find_magnified(const IndexView& index, const ToolFrame& tool, float times, std::size_t most,
                    CandidateSet& candidates);

/// Makes `candidates` empty, all of `index` being ahead. \param grain to begin a sample with, 0 to keep all
void begin_search(const IndexView& index, float grain, CandidateSet& candidates);

/// As find_contacts, among `candidates` alone, found with the same precision, whose t is kept up to date.
void contacts_among(CandidateSet& candidates, const IndexView& index, const ToolFrame& tool,
                    Precision precision, QueryLimit limit, ContactSet& result);

}  // namespace palpate

/// \file
/// Timing of contact queries along a path.
#pragma once

#include <cstddef>
#include <vector>

#include <palpate/base/progress.h>
#include <palpate/collision/scene_index.h>
#include <palpate/haptics/force_model.h>
#include <palpate/haptics/tool.h>
#include <palpate/record/trajectory.h>

namespace palpate {

/// Times of one pose: the minimum over all rounds, since other load only adds time. Unit: [us].
struct PoseFigures {
  double fresh, tracked, force;
  /// Sizes of the stages, see ContactSet.
  std::size_t candidates, filtered, contacts;
};

/// Query to be timed.
struct TimedQuery {
  const ContactQuery& query;
  const SceneIndex* index;  ///< the same, for a contact tracker; null if `query` is no SceneIndex
  Tool tool;
};

/// Times `path` in `rounds` rounds on the calling thread. A round is one pass with fresh queries only, and
/// one as in a servo loop, with the force after the contacts of each pose. Contacts of the latter are from a
/// tracker if there is an index; otherwise PoseFigures::tracked is 0.
std::vector<PoseFigures> time_path(const TimedQuery& timed, const Trajectory& path, ForceModel& model,
                                   int rounds, const Progress& progress);

/// Returns the queries per second of query_batch() on the calling thread's task arena: the best of `rounds`
/// passes over `poses`. \pre poses is not empty.
double time_batches(const TimedQuery& timed, const std::vector<Pose>& poses, int rounds,
                    const Progress& progress);

}  // namespace palpate

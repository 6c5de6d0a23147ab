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
  const SceneIndex* index;  ///< the same, for a tracker to follow; null if `query` is no SceneIndex
  Tool tool;
};

/// Goes along `path` `rounds` times, on the calling thread: once with fresh queries and nothing else, and
/// once as a hand does, each pose's contacts followed by its force. Contacts then come from a tracker, where
/// there is an index, and PoseFigures::tracked is 0 where there is none.
std::vector<PoseFigures> time_path(const TimedQuery& timed, const Trajectory& path, ForceModel& model,
                                   int rounds, const Progress& progress);

/// Returns the queries per second of query_batch() on the calling thread's task arena: the best of `rounds`
/// passes over `poses`. \pre poses is not empty.
double time_batches(const TimedQuery& timed, const std::vector<Pose>& poses, int rounds,
                    const Progress& progress);

}  // namespace palpate

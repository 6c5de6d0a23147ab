/// \file
/// Offline playback of a trajectory against a scene: deterministic, whatever the number of threads.
#pragma once

#include <vector>

#include <palpate/base/progress.h>
#include <palpate/collision/contact.h>
#include <palpate/haptics/force_model.h>
#include <palpate/haptics/tool.h>
#include <palpate/record/run_log.h>
#include <palpate/record/trajectory.h>

namespace palpate {

/// The mean velocity V_WT of the tool from `from` to `to`, world frame; zero if no time passed.
Twist velocity_between(const TimedPose& from, const TimedPose& to);

/// Computes contacts and wrench at every pose, in order. Contacts are found in parallel on the calling
/// thread's task arena; the force model, which has state, processes the poses sequentially. Only
/// RunRow::compute_us differs between two calls.
std::vector<RunRow> play_back(const ContactQuery& query, const Tool& tool, ForceModel& model,
                              const Trajectory& trajectory, const Progress& progress = {});

}  // namespace palpate

/// \file
/// Plays a trajectory against a scene, offline: the same answers every time, on any number of
/// threads.
#pragma once

#include <vector>

#include <palpate/base/progress.h>
#include <palpate/collision/contact.h>
#include <palpate/haptics/force_model.h>
#include <palpate/haptics/tool.h>
#include <palpate/record/run_log.h>
#include <palpate/record/trajectory.h>

namespace palpate {

/// The velocity V_WT that carried the tool from `from` to `to`, world frame; zero if no time passed.
Twist velocity_between(const TimedPose& from, const TimedPose& to);

/// Contacts and wrench at every pose, in order. Contacts are found in parallel on the calling
/// thread's task arena; the force model, which has a memory, sees the poses one after the other.
/// Only RunRow::compute_us differs between two calls.
std::vector<RunRow> play_back(const ContactQuery& query, const Tool& tool, ForceModel& model,
                              const Trajectory& trajectory, const Progress& progress = {});

}  // namespace palpate

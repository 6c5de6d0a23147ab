#include <palpate/record/playback.h>

#include <algorithm>
#include <chrono>
#include <cstddef>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <palpate/geometry/rotation.h>
#include <palpate/haptics/tool_query.h>

namespace palpate {
namespace {

using Clock = std::chrono::steady_clock;

double microseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

/// Number of poses per thread whose contacts are in memory at once: just enough to keep all threads busy. The
/// contacts of a crowded pose take 270 KB. Those of thousands of poses would be in memory not touched before,
/// which costs twice as much as finding them; those of a few stay in the cache until the force model has read
/// them.
constexpr std::size_t kPosesPerThread = 4;

/// Number of poses between two progress reports.
constexpr std::size_t kReportEvery = 4096;

}  // namespace

Twist velocity_between(const TimedPose& from, const TimedPose& to) {
  const double dt = to.t - from.t;
  if (!(dt > 0.0)) return {};
  return {(to.pose.position - from.pose.position) / dt,
          turn_between(from.pose.orientation, to.pose.orientation) / dt};
}

std::vector<RunRow> play_back(const ContactQuery& query, const Tool& tool, ForceModel& model,
                              const Trajectory& trajectory, const Progress& progress) {
  model.reset();
  std::vector<RunRow> rows(trajectory.size());
  const std::size_t block =
      kPosesPerThread * static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  std::vector<ContactSet> contacts(std::min(block, trajectory.size()));
  std::size_t next_report = kReportEvery;
  for (std::size_t first = 0; first < trajectory.size(); first += block) {
    const std::size_t n = std::min(block, trajectory.size() - first);
    tbb::parallel_for(std::size_t{0}, n, [&](std::size_t k) {
      const auto start = Clock::now();
      palpate::query(query, tool, trajectory[first + k].pose, contacts[k]);
      if (model.wants_contacts()) rows[first + k].compute_us = microseconds_since(start);
    });
    for (std::size_t i = first; i < first + n; ++i) {
      const TimedPose& now = trajectory[i];
      const TimedPose& before = trajectory[i > 0 ? i - 1 : 0];
      const ContactSet& set = contacts[i - first];
      RunRow& row = rows[i];
      row.t = now.t;
      row.tool = now.pose;
      row.candidates = set.candidates;
      row.filtered = set.filtered;
      row.colliding = set.contacts.size();
      row.k_max = set.k_max();
      row.user_force = now.user_force;
      const auto start = Clock::now();
      const ForceOutput felt =
          model.evaluate({now.pose, velocity_between(before, now), now.t - before.t, &set});
      row.wrench = felt.wrench;
      row.proxy = felt.proxy.position;
      row.compute_us += microseconds_since(start);
    }
    const std::size_t done = first + n;
    if (done >= next_report || done == trajectory.size()) {
      report(progress, "replaying", static_cast<double>(done) / static_cast<double>(trajectory.size()));
      next_report = done + kReportEvery;
    }
  }
  return rows;
}

}  // namespace palpate

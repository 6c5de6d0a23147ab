#include <palpate/device/playback.h>

#include <algorithm>
#include <chrono>
#include <cstddef>

#include <tbb/parallel_for.h>

#include <palpate/geometry/rotation.h>
#include <palpate/haptics/tool_query.h>

namespace palpate {
namespace {

using Clock = std::chrono::steady_clock;

double microseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

/// Poses whose contacts are held in memory at once.
constexpr std::size_t kBlock = 4096;

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
  std::vector<ContactSet> contacts(std::min(kBlock, trajectory.size()));
  for (std::size_t first = 0; first < trajectory.size(); first += kBlock) {
    const std::size_t n = std::min(kBlock, trajectory.size() - first);
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
    report(progress, "replaying", static_cast<double>(first + n) / static_cast<double>(trajectory.size()));
  }
  return rows;
}

}  // namespace palpate

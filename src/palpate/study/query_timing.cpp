#include <palpate/study/query_timing.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <span>

#include <palpate/collision/batch_query.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/record/playback.h>
#include <palpate/study/latency.h>

namespace palpate {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// Number of solids in a batch: enough to keep all cores busy, few enough that their contacts stay in a
/// cache.
constexpr std::size_t kBatch = 1024;

/// Calls `call`, and lowers `least` to its duration if that is less.
template <typename Call>
void time_call(double& least, const Call& call) {
  const Stopwatch watch;
  call();
  least = std::min(least, watch.microseconds());
}

void go_fresh(const TimedQuery& timed, const Trajectory& path, std::vector<PoseFigures>& figures) {
  ContactSet set;
  for (std::size_t i = 0; i < path.size(); ++i) {
    PoseFigures& f = figures[i];
    time_call(f.fresh, [&] { query(timed.query, timed.tool, path[i].pose, set); });
    f.candidates = set.candidates;
    f.filtered = set.filtered;
    f.contacts = set.contacts.size();
  }
}

void go_as_a_hand(const TimedQuery& timed, const Trajectory& path, ForceModel& model,
                  std::vector<PoseFigures>& figures) {
  std::optional<ToolTracker> tracker;
  if (timed.index != nullptr) tracker.emplace(*timed.index, timed.tool);
  ContactSet set;
  model.reset();
  for (std::size_t i = 0; i < path.size(); ++i) {
    const TimedPose& now = path[i];
    const TimedPose& before = path[i > 0 ? i - 1 : 0];
    if (tracker) {
      time_call(figures[i].tracked, [&] { tracker->query(now.pose, set); });
    } else {
      query(timed.query, timed.tool, now.pose, set);
      figures[i].tracked = 0.0;
    }
    const ForceInput input{now.pose, velocity_between(before, now), now.t - before.t, &set};
    time_call(figures[i].force, [&] { model.evaluate(input); });
  }
}

}  // namespace

std::vector<PoseFigures> time_path(const TimedQuery& timed, const Trajectory& path, ForceModel& model,
                                   int rounds, const Progress& progress) {
  std::vector<PoseFigures> figures(path.size(), {kNever, kNever, kNever, 0, 0, 0});
  for (int round = 0; round < rounds; ++round) {
    go_fresh(timed, path, figures);
    go_as_a_hand(timed, path, model, figures);
    report(progress, "measuring latency", static_cast<double>(round + 1) / rounds);
  }
  return figures;
}

double time_batches(const TimedQuery& timed, const std::vector<Pose>& poses, int rounds,
                    const Progress& progress) {
  std::vector<Ellipsoid> tools;
  for (const Pose& pose : poses)
    for (const ToolPart& part : timed.tool.parts()) tools.push_back(part.at(pose));
  std::vector<ContactSet> results(std::min(kBatch, tools.size()));
  const std::span<const Ellipsoid> all(tools);
  double least = kNever;
  for (int round = 0; round < rounds; ++round) {
    const Stopwatch watch;
    for (std::size_t first = 0; first < all.size(); first += kBatch) {
      const std::size_t n = std::min(kBatch, all.size() - first);
      query_batch(timed.query, all.subspan(first, n), std::span(results).first(n));
    }
    least = std::min(least, watch.seconds());
    report(progress, "measuring throughput", static_cast<double>(round + 1) / rounds);
  }
  return static_cast<double>(all.size()) / least;
}

}  // namespace palpate

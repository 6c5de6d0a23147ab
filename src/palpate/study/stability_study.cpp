#include <palpate/study/stability_study.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <utility>

#include <tbb/parallel_for.h>

#include <palpate/base/quantile.h>
#include <palpate/device/profiles.h>

namespace palpate {
namespace {

/// Computes StabilityRow::force_off from the forces while sliding.
double force_off(const StabilityOutcome& outcome, const StabilityOutcome& reference) {
  constexpr double kShare = 0.95;
  const auto ticks = [](double seconds) { return static_cast<std::size_t>(seconds / StabilityTrial::kTick); };
  const std::size_t end = reference.ticks.size() - ticks(StabilityTrial::kLift);
  const std::size_t begin = end - ticks(StabilityTrial::kSlide);
  std::vector<double> off;
  double sum = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    off.push_back(std::abs(outcome.ticks[i].force - reference.ticks[i].force));
    sum += reference.ticks[i].force;
  }
  const double mean = sum / static_cast<double>(off.size());
  return mean > 0.0 ? quantile(off, kShare) / mean : 0.0;
}

void measure(StabilityRow& row, const StabilityStudy& study) {
  const StabilityTrial trial = trial_of(study, row);
  StabilityTrial in_loop = trial;
  in_loop.worker_delay = in_loop.hold = 0.0;
  bool first = true;
  for (const PressPlace& place : study.places) {
    const StabilityOutcome outcome = hold_on(trial, place, true);
    row.limit_cycle = std::max(row.limit_cycle, outcome.limit_cycle);
    row.port_energy = std::max(row.port_energy, outcome.port_energy);
    row.contact_changes = std::max(row.contact_changes, outcome.contact_changes);
    row.rest_force = first ? outcome.rest_force : std::min(row.rest_force, outcome.rest_force);
    if (row.fault == Fault::kNone) row.fault = outcome.fault;
    if (row.source != ContactSource::kLoop)
      row.force_off = std::max(row.force_off, force_off(outcome, hold_on(in_loop, place, true)));
    first = false;
  }
  if (row.model != "density") row.z_width = z_width(trial, study.places.front(), study.stiffness);
}

std::vector<StabilityRow> rows_of(const StabilityStudy& study) {
  std::vector<StabilityRow> rows;
  for (const std::string& profile : study.profiles) {
    for (const std::string& model : study.models) {
      for (const auto source : {ContactSource::kLoop, ContactSource::kWorker, ContactSource::kHold}) {
        if (source != ContactSource::kLoop && study.delay == 0.0) continue;
        for (const HandProperties& hand : study.hands) {
          StabilityRow row;
          row.profile = profile;
          row.model = model;
          row.hand = hand;
          row.source = source;
          row.delay = source == ContactSource::kLoop ? 0.0 : study.delay;
          rows.push_back(row);
        }
      }
    }
  }
  return rows;
}

}  // namespace

std::string_view to_string(ContactSource source) {
  switch (source) {
    case ContactSource::kLoop: return "loop";
    case ContactSource::kWorker: return "worker";
    default: return "hold";
  }
}

StabilityTrial trial_of(const StabilityStudy& study, const StabilityRow& row) {
  StabilityTrial trial;
  trial.index = study.index;
  trial.tool = study.tool;
  trial.profile = device_profile(row.profile);
  trial.hand = row.hand;
  trial.model = [&study, name = row.model](Lookahead* ahead) { return study.model(name, ahead); };
  if (row.source == ContactSource::kWorker) trial.worker_delay = row.delay;
  if (row.source == ContactSource::kHold) trial.hold = row.delay;
  // A model without a potential, or with a delay, is not passive: it runs ungoverned.
  trial.governed = row.source != ContactSource::kHold && row.model != "density";
  return trial;
}

StabilityTables measure_stability(const StabilityStudy& study, const Progress& progress) {
  StabilityTables tables{rows_of(study), {}};
  std::mutex watched;
  std::size_t done = 0;
  tbb::parallel_for(std::size_t{0}, tables.rows.size(), [&](std::size_t i) {
    measure(tables.rows[i], study);
    const std::scoped_lock lock(watched);
    report(progress, "stability trials",
           static_cast<double>(++done) / static_cast<double>(tables.rows.size() + 1));
  });
  for (const std::string& name : study.profiles) {
    const DeviceProfile& profile = device_profile(name);
    const double period = 1.0 / profile.capabilities.rate;
    for (const bool passivity : {false, true}) {
      tables.walls.push_back(
          {name, passivity, wall_z_width(profile, period, passivity),
           wall_bound(profile, period, passivity ? profile.capabilities.damping_max : 0.0)});
    }
  }
  report(progress, "stability trials", 1.0);
  return tables;
}

std::vector<HandProperties> usual_hands() {
  std::vector<HandProperties> hands;
  for (const double mass : {0.05, 0.15, 0.3}) {
    for (const auto& [damping, stiffness] :
         {std::pair(1.0, 100.0), std::pair(3.0, 400.0), std::pair(10.0, 1000.0)})
      hands.push_back({mass, damping, stiffness});
  }
  return hands;
}

}  // namespace palpate

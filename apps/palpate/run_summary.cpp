#include "run_summary.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace palpate::cli {
namespace {

constexpr double kMicro = 1e6;

Json times_json(const TimeHistogram& times) {
  return {{"p50", kMicro * times.quantile(0.5)},
          {"p99", kMicro * times.quantile(0.99)},
          {"p999", kMicro * times.quantile(0.999)},
          {"max", kMicro * times.max()}};
}

std::vector<std::string> faults_of(const LiveView& view) {
  std::vector<std::string> names;
  for (const GovernorTransition& change : view.transitions()) {
    const std::string name(traits(change.fault).name);
    if (change.fault != Fault::kNone && std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
  }
  return names;
}

}  // namespace

Outcome outcome_of(LiveSystem& system, const LiveView& view) {
  return {system.clock().now(), system.loop().statistics().ticks, view.totals(), view.newest().state,
          faults_of(view)};
}

Json to_json(const Outcome& outcome, LiveSystem& system) {
  const LoopStatistics& statistics = system.loop().statistics();
  const LiveTotals& totals = outcome.totals;
  return {{"ticks", outcome.ticks},
          {"rate_hz", static_cast<double>(outcome.ticks) / outcome.seconds},
          {"overruns", statistics.overruns.load()},
          {"tick_us", times_json(statistics.whole)},
          {"cpu_us", times_json(statistics.spent)},
          {"age_us", times_json(statistics.age)},
          {"late_us", times_json(statistics.late)},
          {"contact_ticks", totals.contact_ticks},
          {"contacts_max", totals.contacts_max},
          {"force_max", totals.force_max},
          {"port_energy", totals.port_energy},
          {"margin_min", totals.margin_min},
          {"state", to_string(outcome.state)},
          {"faults", outcome.faults}};
}

void print_text(const Outcome& outcome, LiveSystem& system) {
  const LoopStatistics& statistics = system.loop().statistics();
  const LiveTotals& totals = outcome.totals;
  const auto times = [](const char* name, const TimeHistogram& h) {
    fmt::print("{:<16} p50 {:.1f} us, p99 {:.1f}, p99.9 {:.1f}, max {:.0f}\n", name, kMicro * h.quantile(0.5),
               kMicro * h.quantile(0.99), kMicro * h.quantile(0.999), kMicro * h.max());
  };
  fmt::print("{} ticks in {:.1f} s, {:.0f} Hz, {} overruns; {}\n", outcome.ticks, outcome.seconds,
             static_cast<double>(outcome.ticks) / outcome.seconds, statistics.overruns.load(),
             to_string(outcome.state));
  times("tick", statistics.whole);
  times("of it computing", statistics.spent);
  times("age of the force", statistics.age);
  times("late", statistics.late);
  fmt::print("in contact       {:.1f} % of the ticks, up to {} contacts, up to {:.2f} N\n",
             100.0 * static_cast<double>(totals.contact_ticks) /
                 static_cast<double>(std::max<std::uint64_t>(1, outcome.ticks)),
             totals.contacts_max, totals.force_max);
  fmt::print("port             put out at most {:.3f} mJ more than it took in; stiffness {}\n",
             1e3 * totals.port_energy,
             totals.margin_min >= 1.0 ? fmt::format("could be {:.1f} times as large", totals.margin_min)
             : totals.margin_min > 0.0
                 ? fmt::format("was lowered to {:.2f} of what was set: forces come too late for more",
                               totals.margin_min)
                 : "has no margin to tell");
  if (!outcome.faults.empty()) fmt::print("faults           {}\n", fmt::join(outcome.faults, ", "));
}

}  // namespace palpate::cli

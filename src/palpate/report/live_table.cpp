#include <palpate/report/live_table.h>

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace palpate {
namespace {

constexpr double kMicro = 1e6;

OrderedJson times_json(const TimeHistogram& times) {
  return {{"p50", kMicro * times.quantile(0.5)},
          {"p99", kMicro * times.quantile(0.99)},
          {"p999", kMicro * times.quantile(0.999)},
          {"max", kMicro * times.max()}};
}

}  // namespace

std::vector<std::string> faults_of(const LiveView& view) {
  std::vector<std::string> names;
  const auto add = [&names](Fault fault) {
    const std::string name(traits(fault).name);
    if (fault != Fault::kNone && std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
  };
  for (const GovernorTransition& change : view.transitions()) add(change.fault);
  if (view.has_stalled()) add(Fault::kStalled);
  return names;
}

OrderedJson live_json(const LiveOutcome& outcome, const LoopStatistics& statistics) {
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
          {"faults", outcome.faults},
          {"lost", outcome.lost}};
}

std::string live_text(const LiveOutcome& outcome, const LoopStatistics& statistics) {
  std::string text;
  const LiveTotals& totals = outcome.totals;
  const auto times = [&text](const char* name, const TimeHistogram& h) {
    text += fmt::format("{:<22} p50 {:.1f} us, p99 {:.1f}, p99.9 {:.1f}, max {:.0f}\n", name,
                        kMicro * h.quantile(0.5), kMicro * h.quantile(0.99), kMicro * h.quantile(0.999),
                        kMicro * h.max());
  };
  text += fmt::format("{} ticks in {:.1f} s, {:.0f} Hz, {} overruns; {}\n", outcome.ticks, outcome.seconds,
                      static_cast<double>(outcome.ticks) / outcome.seconds, statistics.overruns.load(),
                      to_string(outcome.state));
  times("tick", statistics.whole);
  times("processor time", statistics.spent);
  times("reading age at output", statistics.age);
  times("start delay", statistics.late);
  text += fmt::format("in contact             {:.1f} % of the ticks, up to {} contacts, up to {:.2f} N\n",
                      100.0 * static_cast<double>(totals.contact_ticks) /
                          static_cast<double>(std::max<std::uint64_t>(1, outcome.ticks)),
                      totals.contacts_max, totals.force_max);
  text +=
      fmt::format("net energy output      at most {:.3f} mJ; stiffness {}\n", 1e3 * totals.port_energy,
                  totals.margin_min >= 1.0 ? fmt::format("margin {:.1f}", totals.margin_min)
                  : totals.margin_min > 0.0
                      ? fmt::format("reduced to {:.2f} of the setting because of delay", totals.margin_min)
                      : "margin unknown");
  if (!outcome.faults.empty())
    text += fmt::format("faults                 {}\n", fmt::join(outcome.faults, ", "));
  return text;
}

}  // namespace palpate

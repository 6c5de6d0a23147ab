#include <palpate/report/bench_table.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/base/quantile.h>
#include <palpate/report/histogram.h>
#include <palpate/study/latency.h>
#include <palpate/study/machine.h>

namespace palpate {
namespace {

/// Collects a figure of the poses in contact, or of those without contact.
template <typename T, typename U>
std::vector<T> collect(const std::vector<PoseFigures>& poses, bool touching, U PoseFigures::*figure) {
  std::vector<T> values;
  for (const PoseFigures& pose : poses)
    if ((pose.contacts != 0) == touching) values.push_back(static_cast<T>(pose.*figure));
  return values;
}

struct SizeSpread {
  std::size_t median, max;
};

SizeSpread spread_of(const BenchFigures& figures, std::size_t PoseFigures::*size) {
  std::vector<double> values = collect<double>(figures.poses, true, size);
  return {static_cast<std::size_t>(quantile(values, 0.5)), static_cast<std::size_t>(quantile(values, 1.0))};
}

/// A stage of a query, last stage first.
struct Stage {
  const char* key;
  const char* name;
  std::size_t PoseFigures::*size;
};
constexpr Stage kStages[] = {{"contacts", "contacts", &PoseFigures::contacts},
                             {"filtered", "after bounding-sphere test", &PoseFigures::filtered},
                             {"candidates", "candidates", &PoseFigures::candidates}};

OrderedJson latency_json(const Phase& phase) {
  if (phase.times.empty()) return nullptr;
  const Latency t(phase.times);
  return {{"count", t.count}, {"p50", t.median}, {"p99", t.p99}, {"p99.9", t.p999}, {"max", t.max}};
}

OrderedJson sizes_json(const BenchFigures& figures) {
  if (figures.contact_poses() == 0) return nullptr;
  OrderedJson json;
  for (const Stage& stage : kStages) {
    const SizeSpread spread = spread_of(figures, stage.size);
    json[stage.key] = {{"median", spread.median}, {"max", spread.max}};
  }
  return json;
}

std::optional<double> bytes_per_gaussian(const OpenFigures& open) {
  if (!open.index_bytes || open.gaussians == 0) return {};
  return static_cast<double>(*open.index_bytes) / static_cast<double>(open.gaussians);
}

OrderedJson open_json(const OpenFigures& open) {
  OrderedJson json{{"seconds", open.seconds}, {"origin", open.origin}, {"remarks", open.remarks}};
  json["index_bytes"] = open.index_bytes ? OrderedJson(*open.index_bytes) : OrderedJson();
  const auto each = bytes_per_gaussian(open);
  json["bytes_per_gaussian"] = each ? OrderedJson(*each) : OrderedJson();
  json["peak_rss_bytes"] = open.peak_bytes;
  return json;
}

std::string megabytes(std::uint64_t bytes) {
  return fmt::format("{:.3g} MB", 1e-6 * static_cast<double>(bytes));
}

std::string head_text(const BenchFigures& f) {
  std::string text;
  text += fmt::format("machine   {}\n", machine());
  text += fmt::format("scene     {}, {}, {} Gaussians\n", printable(f.scene), megabytes(f.open.scene_bytes),
                      f.open.gaussians);
  text += fmt::format("query     {} on {}; tool {}; {} force\n", f.pipeline, f.simd, f.tool_name, f.model);
  text += fmt::format("path      {}: {} poses, {} in contact\n",
                      f.path.empty() ? "generated" : printable(f.path), f.poses.size(), f.contact_poses());
  text += fmt::format("open      {:.3g} s, from {}{}\n", f.open.seconds, f.open.origin,
                      f.open.index_bytes ? fmt::format(", {}", megabytes(*f.open.index_bytes)) : "");
  for (const std::string& remark : f.open.remarks) text += fmt::format("          {}\n", printable(remark));
  return text;
}

std::string latencies_text(const BenchFigures& figures) {
  std::string text;
  text +=
      fmt::format("\n{:<26} {:>9} {:>10} {:>10} {:>10} {:>10}\n",
                  fmt::format("minimum of {} rounds", figures.rounds), "count", "p50", "p99", "p99.9", "max");
  for (const Phase& phase : phases_of(figures)) {
    if (phase.times.empty()) {
      text += fmt::format("{:<26} {:>9}\n", phase.name, "none");
      continue;
    }
    const Latency t(phase.times);
    text +=
        fmt::format("{:<26} {:>9} {:>10} {:>10} {:>10} {:>10}\n", phase.name, t.count, microseconds(t.median),
                    microseconds(t.p99), microseconds(t.p999), microseconds(t.max));
  }
  return text;
}

std::string sizes_text(const BenchFigures& figures) {
  std::string text;
  if (figures.contact_poses() == 0) {
    text += fmt::format("\nthe path never touches the scene: no contacts to time or count\n");
    return text;
  }
  text += fmt::format("\n{:<26} {:>9} {:>10}\n", "per pose in contact", "median", "max");
  for (const Stage& stage : kStages) {
    const SizeSpread spread = spread_of(figures, stage.size);
    text += fmt::format("{:<26} {:>9} {:>10}\n", stage.name, spread.median, spread.max);
  }
  return text;
}

std::string rest_text(const BenchFigures& f) {
  std::string text;
  text += fmt::format("\nthroughput  {:.0f} queries/s {}on {} thread{}\n", f.queries_per_second,
                      f.contact_poses() != 0 ? "in contact " : "", f.threads, f.threads == 1 ? "" : "s");
  text += fmt::format("memory      ");
  if (const auto each = bytes_per_gaussian(f.open)) {
    text += fmt::format("index {}, {:.1f} bytes per Gaussian; ", megabytes(*f.open.index_bytes), *each);
  }
  text += fmt::format("peak resident memory while opening: {}\n", megabytes(f.open.peak_bytes));
  return text;
}

}  // namespace

std::size_t BenchFigures::contact_poses() const {
  const auto touches = [](const PoseFigures& pose) { return pose.contacts != 0; };
  return static_cast<std::size_t>(std::count_if(poses.begin(), poses.end(), touches));
}

std::vector<Phase> phases_of(const BenchFigures& figures) {
  const auto times = [&](bool touching, double PoseFigures::*figure) {
    return collect<double>(figures.poses, touching, figure);
  };
  std::vector<Phase> phases{{"query_contact", "fresh query, in contact", times(true, &PoseFigures::fresh)},
                            {"query_free", "fresh query, no contact", times(false, &PoseFigures::fresh)},
                            {"tracker_contact", "tracker, in contact", times(true, &PoseFigures::tracked)},
                            {"force_contact", "force model, in contact", times(true, &PoseFigures::force)}};
  if (!figures.tracked) phases[2].times.clear();
  return phases;
}

std::vector<double> histogram_times(const BenchFigures& figures) {
  return collect<double>(figures.poses, figures.contact_poses() != 0, &PoseFigures::fresh);
}

std::string bench_histogram(const BenchFigures& f) {
  const std::vector<double> times = histogram_times(f);
  const Latency t(times);
  const std::string name = std::filesystem::path(f.scene).filename().string();
  return histogram_svg(
      times, {{"p50", t.median}, {"p99", t.p99}, {"p99.9", t.p999}},
      fmt::format("Contact query in {}", printable(name)),
      fmt::format("{} Gaussians, {} poses {}, {} on {}, one thread, minimum of {} rounds per pose",
                  f.open.gaussians, times.size(), f.contact_poses() != 0 ? "in contact" : "out of contact",
                  f.pipeline, f.simd, f.rounds));
}

OrderedJson bench_json(const BenchFigures& f) {
  OrderedJson json{{"machine", machine()},
                   {"scene", f.scene},
                   {"scene_bytes", f.open.scene_bytes},
                   {"gaussians", f.open.gaussians},
                   {"pipeline", f.pipeline},
                   {"simd", f.simd},
                   {"model", f.model},
                   {"tool", tool_json(f.tool)},
                   {"open", open_json(f.open)}};
  json["path"] = f.path.empty() ? OrderedJson() : OrderedJson(f.path);
  json["poses"] = f.poses.size();
  json["contact_poses"] = f.contact_poses();
  json["rounds"] = f.rounds;
  for (const Phase& phase : phases_of(f)) json["latency_us"][phase.key] = latency_json(phase);
  json["sizes"] = sizes_json(f);
  json["throughput"] = {{"threads", f.threads},
                        {"queries_per_second", f.queries_per_second},
                        {"in_contact", f.contact_poses() != 0}};
  return json;
}

std::string bench_text(const BenchFigures& figures, bool with_histogram) {
  std::string text = head_text(figures) + latencies_text(figures) + sizes_text(figures) + rest_text(figures);
  if (with_histogram) text += fmt::format("\n{}", histogram_text(histogram_times(figures)));
  return text;
}

}  // namespace palpate

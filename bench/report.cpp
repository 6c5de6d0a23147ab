#include "report.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <palpate/base/file.h>

namespace palpate::bench {
namespace {

using nlohmann::ordered_json;

/// Reference medians in contact; infinite if there is no such pipeline.
struct Yardsticks {
  double paper = std::numeric_limits<double>::infinity();
  double best_peer = std::numeric_limits<double>::infinity();

  explicit Yardsticks(const Comparison& comparison) {
    for (const PipelineResult& r : comparison.results) {
      if (!r.family.peer) continue;
      best_peer = std::min(best_peer, r.contact.median);
      if (r.family.name == kPaper) paper = r.contact.median;
    }
  }
};

std::string ratio(double yardstick, double own) {
  return std::isfinite(yardstick) && own > 0.0 ? fmt::format("{:.3g}x", yardstick / own) : "-";
}

std::string row(const PipelineResult& r, const Yardsticks& yardsticks) {
  const Latency& t = r.contact;
  const std::string worst_k =
      std::isnan(r.accuracy.worst_k) ? "no K" : fmt::format("{:.1e}", r.accuracy.worst_k);
  return fmt::format("| {} | {} | {} | {} | {} | {} | {} / {} | {} | {:.2f} s | {:.0f} MB | {} | {} |\n",
                     r.name, microseconds(t.median), microseconds(t.p99), microseconds(t.p999),
                     microseconds(t.max), microseconds(t.mean), r.accuracy.misses, r.accuracy.extras, worst_k,
                     r.build_seconds, 1e-6 * static_cast<double>(r.bytes), ratio(yardsticks.paper, t.median),
                     ratio(yardsticks.best_peer, t.median));
}

ordered_json to_json(const Latency& t) {
  return {{"median", t.median}, {"p99", t.p99}, {"p99.9", t.p999}, {"max", t.max}, {"mean", t.mean}};
}

ordered_json to_json(const PipelineResult& r) {
  return {{"name", r.name},
          {"contact_us", to_json(r.contact)},
          {"free_us", to_json(r.free)},
          {"misses", r.accuracy.misses},
          {"extras", r.accuracy.extras},
          {"worst_k_error", r.accuracy.worst_k},  // NaN becomes null
          {"worst_missed_k", r.accuracy.worst_missed},
          {"build_s", r.build_seconds},
          {"bytes", r.bytes}};
}

std::string size(std::uint64_t bytes) {
  const auto b = static_cast<double>(bytes);
  return b < 1e9 ? fmt::format("{:.3g} MB", 1e-6 * b) : fmt::format("{:.3g} GB", 1e-9 * b);
}

std::string order_of(const PoseOptions& poses) {
  return fmt::format("{}{}", poses.whole_scene ? "over the whole scene" : "1 kHz strokes",
                     poses.shuffle ? ", shuffled" : "");
}

}  // namespace

std::string to_markdown(const Comparison& c) {
  const ComparisonOptions& o = c.options;
  std::string text = fmt::format(
      "{} Gaussians at {} sigma; tool {:g}/{:g}/{:g} mm; {} poses ({}), seed {}, {} in contact; {} hits, "
      "{:.1f} a contact pose; kd-tree radius {:.3f} m, complete {:.3f} m; one thread; the minimum of {} "
      "rounds "
      "a "
      "pose; contact poses only; memory is growth of the resident set\n\n",
      o.gaussians, o.sigma, 1e3 * o.poses.tool[0], 1e3 * o.poses.tool[1], 1e3 * o.poses.tool[2],
      o.poses.count, order_of(o.poses), o.poses.seed, c.contact_poses, c.hits, c.hits_per_contact_pose(),
      c.search_radius, c.complete_radius, o.rounds);
  text +=
      "| pipeline | median | p99 | p99.9 | max | mean | misses / extras | worst dK | build | memory "
      "| paper's is | best peer is |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  const Yardsticks yardsticks(c);
  for (const PipelineResult& r : c.results) text += row(r, yardsticks);
  return text;
}

ordered_json to_json(const Comparison& c) {
  const ComparisonOptions& o = c.options;
  ordered_json results = ordered_json::array();
  for (const PipelineResult& r : c.results) results.push_back(to_json(r));
  return {{"gaussians", o.gaussians},
          {"spacing_m", o.spacing},
          {"sigma", o.sigma},
          {"tool_m", {o.poses.tool[0], o.poses.tool[1], o.poses.tool[2]}},
          {"poses", o.poses.count},
          {"order", order_of(o.poses)},
          {"seed", o.poses.seed},
          {"rounds", o.rounds},
          {"contact_poses", c.contact_poses},
          {"hits", c.hits},
          {"search_radius_m", c.search_radius},
          {"complete_radius_m", c.complete_radius},
          {"pipelines", results}};
}

std::string to_markdown(const SceneFileResult& f) {
  return fmt::format(
      "\n- {} Gaussians: scene file {}, index file {}\n"
      "- from one to the other: {:.1f} s on all cores, at most {} of anonymous memory\n"
      "- first contact, the index file being there: {:.2f} s with none of it in memory, {:.2f} s again\n",
      f.strokes.options.gaussians, size(f.scene_bytes), size(f.index_bytes), f.index_seconds,
      size(f.index_anonymous), f.first_contact_cold, f.first_contact_warm);
}

ordered_json to_json(const SceneFileResult& f) {
  return {{"scene_bytes", f.scene_bytes},
          {"index_bytes", f.index_bytes},
          {"index_s", f.index_seconds},
          {"index_anonymous_bytes", f.index_anonymous},
          {"first_contact_cold_s", f.first_contact_cold},
          {"first_contact_warm_s", f.first_contact_warm},
          {"strokes", to_json(f.strokes)},
          {"whole_scene", to_json(f.whole_scene)}};
}

void publish(const std::string& markdown, const std::string& markdown_path, const ordered_json& json,
             const std::string& json_path) {
  fmt::print("{}", markdown);
  if (!markdown_path.empty()) write_file(markdown_path, markdown);
  if (!json_path.empty()) write_file(json_path, json.dump(2) + "\n");
}

}  // namespace palpate::bench

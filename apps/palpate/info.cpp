// palpate info: what is in a scene file, what is wrong with it, and what the filter keeps.
#include <cstdio>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/live/setup_json.h>
#include <palpate/scene/lint.h>

#include "command.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "setup.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

Json to_json(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return nullptr;
  return {{"min", vector_json(box.min())}, {"max", vector_json(box.max())}};
}

Json to_json(const Quantiles& quantiles) {
  Json json;
  for (std::size_t k = 0; k < kQuantiles.size(); ++k) json[fmt::format("{}", kQuantiles[k])] = quantiles[k];
  return json;
}

Json defects_to_json(const std::array<std::size_t, kDefectCount>& defects) {
  Json json;
  for (std::size_t k = 1; k < kDefectCount; ++k) json[to_string(static_cast<Defect>(k))] = defects[k];
  return json;
}

Eigen::AlignedBox3d bounds_of(const EllipsoidScene& scene) {
  Eigen::AlignedBox3d box;
  for (const Ellipsoid& e : scene.ellipsoids) {
    box.extend(e.center - e.half_extents());
    box.extend(e.center + e.half_extents());
  }
  return box;
}

Json to_json(const LoadedScene& loaded, const LintReport& lint, const SceneConfig& options) {
  const GaussianScene& scene = loaded.scene;
  Json json{{"file", scene.source},
            {"format", scene.format},
            {"gaussians", scene.size()},
            {"sh_degree", scene.sh_degree},
            {"trailing_bytes", scene.trailing_bytes}};
  json["bounds"] = to_json(lint.bounds);
  json["robust_bounds"] = to_json(lint.robust_bounds);
  json["opacity"] = to_json(lint.opacity);
  json["longest_sigma"] = to_json(lint.longest_sigma);
  json["shortest_sigma"] = to_json(lint.shortest_sigma);
  Json& findings = json["lint"] = defects_to_json(lint.defects);
  findings["giant"] = lint.giant;
  findings["flat"] = lint.flat;
  const FilterReport& f = loaded.filtered;
  json["filter"] = {{"opacity_min", options.filter.opacity_min},
                    {"kept", f.kept},
                    {"share", static_cast<double>(f.kept) / static_cast<double>(f.total)},
                    {"defective", f.defective()},
                    {"low_opacity", f.low_opacity},
                    {"below_iso", f.below_iso},
                    {"over_max_scale", f.over_max_scale},
                    {"outside_crop", f.outside_crop}};
  for (std::size_t k = 0; k < kPaperThresholds.size(); ++k)
    json["kept_share"][fmt::format("{}", kPaperThresholds[k])] = lint.share_above[k];
  json["frame"] = options.frame_note();
  json["world_bounds"] = to_json(bounds_of(loaded.kept));
  return json;
}

void print_row(const char* name, const Quantiles& quantiles) {
  fmt::print("  {:<16}", name);
  for (const double q : quantiles) fmt::print(" {:>9.3g}", q);
  fmt::print("\n");
}

void print_box(const char* name, const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return;
  fmt::print("{:<17} {:.4g} {:.4g} {:.4g}  to  {:.4g} {:.4g} {:.4g}\n", name, box.min().x(), box.min().y(),
             box.min().z(), box.max().x(), box.max().y(), box.max().z());
}

void print_counts(const LintReport& lint, const FilterReport& f, const SceneConfig& options) {
  fmt::print(
      "\nlint              {} NaN, {} infinite, {} zero quaternion, {} zero scale: cannot collide, left "
      "out\n",
      lint.defects[1], lint.defects[2], lint.defects[3], lint.defects[4]);
  fmt::print(
      "                  {} giant (longest sigma above {:.3g}, a tenth of the scene){}, {} flat (a sigma of "
      "zero)\n",
      lint.giant, kGiantShare * lint.robust_diagonal, lint.giant != 0 ? ": drop them with --max-scale" : "",
      lint.flat);
  fmt::print("\nkept              {} of {} ({:.1f} %) at opacity above {}\n", f.kept, f.total,
             100.0 * static_cast<double>(f.kept) / static_cast<double>(f.total), options.filter.opacity_min);
  fmt::print(
      "dropped           {} defective, {} low opacity, {} below iso, {} above max scale, {} outside the "
      "crop\n",
      f.defective(), f.low_opacity, f.below_iso, f.over_max_scale, f.outside_crop);
}

void print_text(const LoadedScene& loaded, const LintReport& lint, const SceneConfig& options) {
  const GaussianScene& scene = loaded.scene;
  fmt::print("{}\n{}, {} Gaussians", printable(scene.source), scene.format, scene.size());
  if (scene.trailing_bytes != 0) fmt::print(", {} bytes after the data", scene.trailing_bytes);
  fmt::print("\n\n");
  print_box("centres", lint.bounds);
  print_box("central 98 %", lint.robust_bounds);
  fmt::print("\n  {:<16}", "quantile");
  for (const double q : kQuantiles) fmt::print(" {:>9}", q);
  fmt::print("\n");
  print_row("opacity", lint.opacity);
  print_row("longest sigma", lint.longest_sigma);
  print_row("shortest sigma", lint.shortest_sigma);
  print_counts(lint, loaded.filtered, options);
  fmt::print("share kept        {:.1f} % above 0.1, {:.1f} % above 0.2, {:.1f} % above 0.3\n",
             100 * lint.share_above[0], 100 * lint.share_above[1], 100 * lint.share_above[2]);
  fmt::print("\nworld             {}; scale {} m/unit\n", options.frame_note(), options.registration.scale);
  print_box("kept ellipsoids", bounds_of(loaded.kept));
}

}  // namespace

Command declare_info(CLI::App& parent) {
  CLI::App& app = add_command(
      parent, "info", "Counts, bounds, opacity and scale quantiles, lint findings, what the filter keeps");
  auto common = std::make_shared<CommonOptions>();
  auto live = std::make_shared<LiveConfig>();
  declare_common(app, *common, "print figures as JSON");
  declare_scene(app, *live, SceneArgument::kPositional);
  return {&app, [=] {
            const LoadedScene loaded = load(live->scene, terminal_progress(common->quiet));
            const LintReport report = lint(loaded.scene);
            std::optional<SceneSetup> setup;
            if (report.defects[0] != 0) setup = propose_setup(loaded.scene, live->tool);
            if (common->json) {
              Json json = to_json(loaded, report, live->scene);
              json["proposed"] = setup ? setup_json<Json>(*setup) : Json();
              json["made"] = made_json(made_by(*common, *live, {ConfigGroup::kScene}));
              print_json(json);
            } else {
              print_text(loaded, report, live->scene);
              if (setup) print_setup(*setup);
            }
          }};
}

}  // namespace palpate::cli

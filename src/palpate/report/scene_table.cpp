#include <palpate/report/scene_table.h>

#include <cmath>
#include <cstddef>
#include <string>

#include <fmt/format.h>

#include <palpate/base/error.h>

namespace palpate {
namespace {

OrderedJson to_json(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return nullptr;
  return {{"min", vector_json(box.min())}, {"max", vector_json(box.max())}};
}

OrderedJson to_json(const Quantiles& quantiles) {
  OrderedJson json;
  for (std::size_t k = 0; k < kQuantiles.size(); ++k) json[fmt::format("{}", kQuantiles[k])] = quantiles[k];
  return json;
}

OrderedJson defects_to_json(const std::array<std::size_t, kDefectCount>& defects) {
  OrderedJson json;
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

std::string row_text(const char* name, const Quantiles& quantiles) {
  std::string text;
  text += fmt::format("  {:<16}", name);
  for (const double q : quantiles) text += fmt::format(" {:>9.3g}", q);
  text += "\n";
  return text;
}

std::string box_text(const char* name, const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return {};
  return fmt::format("{:<17} {:.4g} {:.4g} {:.4g}  to  {:.4g} {:.4g} {:.4g}\n", name, box.min().x(),
                     box.min().y(), box.min().z(), box.max().x(), box.max().y(), box.max().z());
}

/// Returns `value`, positive, with three significant digits, rounded down: as a limit it excludes whatever
/// exceeds `value`.
std::string floor_text(double value) {
  const double step = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
  const double floored = std::floor(value / step) * step;
  std::string text = fmt::format("{:.3g}", floored);
  // The nearest decimal of three digits may be above a `value` that is just below it.
  if (std::stod(text) > value) text = fmt::format("{:.3g}", floored - step);
  return text;
}

/// The limit of LintReport::giant, and the option that drops those Gaussians: both in the world's metres.
std::string giants_text(const SceneReport& report) {
  const std::size_t count = report.lint.giant;
  const double limit = report.scale * kGiantShare * report.lint.robust_diagonal;
  const std::string metres = limit > 0.0 ? floor_text(limit) : "0";
  return fmt::format("{} giant (longest sigma above {} m, a tenth of the scene){}", count, metres,
                     count != 0 ? ": drop them with --max-scale " + metres : "");
}

std::string counts_text(const SceneReport& report) {
  const LintReport& lint = report.lint;
  const FilterReport& f = report.filtered;
  std::string text;
  text += fmt::format(
      "\nlint              {} NaN, {} infinite, {} zero quaternion, {} zero scale: cannot collide, "
      "excluded\n",
      lint.defects[1], lint.defects[2], lint.defects[3], lint.defects[4]);
  text += fmt::format("                  {}, {} flat (a sigma of zero)\n", giants_text(report), lint.flat);
  text += fmt::format("\nkept              {} of {} ({:.1f} %) at opacity above {}\n", f.kept, f.total,
                      100.0 * static_cast<double>(f.kept) / static_cast<double>(f.total), report.opacity_min);
  text += fmt::format(
      "dropped           {} defective, {} low opacity, {} below iso, {} above max scale, {} outside the "
      "crop\n",
      f.defective(), f.low_opacity, f.below_iso, f.over_max_scale, f.outside_crop);
  return text;
}

}  // namespace

OrderedJson scene_json(const SceneReport& report) {
  const GaussianScene& scene = report.scene;
  const LintReport& lint = report.lint;
  OrderedJson json{{"file", scene.source},
                   {"format", scene.format},
                   {"gaussians", scene.size()},
                   {"sh_degree", scene.sh_degree},
                   {"trailing_bytes", scene.trailing_bytes}};
  json["bounds"] = to_json(lint.bounds);
  json["robust_bounds"] = to_json(lint.robust_bounds);
  json["opacity"] = to_json(lint.opacity);
  json["longest_sigma"] = to_json(lint.longest_sigma);
  json["shortest_sigma"] = to_json(lint.shortest_sigma);
  OrderedJson& findings = json["lint"] = defects_to_json(lint.defects);
  findings["giant"] = lint.giant;
  findings["flat"] = lint.flat;
  const FilterReport& f = report.filtered;
  json["filter"] = {{"opacity_min", report.opacity_min},
                    {"kept", f.kept},
                    {"share", static_cast<double>(f.kept) / static_cast<double>(f.total)},
                    {"defective", f.defective()},
                    {"low_opacity", f.low_opacity},
                    {"below_iso", f.below_iso},
                    {"over_max_scale", f.over_max_scale},
                    {"outside_crop", f.outside_crop}};
  for (std::size_t k = 0; k < kPaperThresholds.size(); ++k)
    json["kept_share"][fmt::format("{}", kPaperThresholds[k])] = lint.share_above[k];
  json["frame"] = report.frame;
  json["world_bounds"] = to_json(bounds_of(report.kept));
  return json;
}

std::string scene_text(const SceneReport& report) {
  std::string text;
  const GaussianScene& scene = report.scene;
  const LintReport& lint = report.lint;
  text += fmt::format("{}\n{}, {} Gaussians", printable(scene.source), scene.format, scene.size());
  if (scene.trailing_bytes != 0) text += fmt::format(", {} bytes after the data", scene.trailing_bytes);
  text += "\n\n";
  text += box_text("centres", lint.bounds);
  text += box_text("central 98 %", lint.robust_bounds);
  text += fmt::format("\n  {:<16}", "quantile");
  for (const double q : kQuantiles) text += fmt::format(" {:>9}", q);
  text += "\n";
  text += row_text("opacity", lint.opacity);
  text += row_text("longest sigma", lint.longest_sigma);
  text += row_text("shortest sigma", lint.shortest_sigma);
  text += counts_text(report);
  text += fmt::format("share kept        {:.1f} % above 0.1, {:.1f} % above 0.2, {:.1f} % above 0.3\n",
                      100 * lint.share_above[0], 100 * lint.share_above[1], 100 * lint.share_above[2]);
  text += fmt::format("\nworld             {}; scale {} m/unit\n", report.frame, report.scale);
  text += box_text("kept ellipsoids", bounds_of(report.kept));
  return text;
}

}  // namespace palpate

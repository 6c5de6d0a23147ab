#include <palpate/scene/lint.h>

#include <algorithm>
#include <vector>

#include <palpate/base/quantile.h>

namespace palpate {
namespace {

Quantiles quantiles(std::vector<double>& values) {
  Quantiles result{};
  for (std::size_t k = 0; k < kQuantiles.size(); ++k) result[k] = quantile(values, kQuantiles[k]);
  return result;
}

}  // namespace

LintReport lint(const GaussianScene& scene) {
  LintReport report;
  report.total = scene.size();
  std::array<std::vector<double>, 3> coordinates;
  std::vector<double> opacity, longest, shortest;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const Gaussian g = scene.gaussian(i);
    const Defect d = defect(scene, i, g);
    ++report.defects[static_cast<std::size_t>(d)];
    if (d != Defect::kNone) continue;
    report.bounds.extend(g.position);
    for (std::size_t axis = 0; axis < 3; ++axis)
      coordinates[axis].push_back(g.position[static_cast<int>(axis)]);
    opacity.push_back(g.opacity);
    longest.push_back(g.sigma.maxCoeff());
    shortest.push_back(g.sigma.minCoeff());
    if (shortest.back() == 0.0) ++report.flat;
  }
  if (opacity.empty()) return report;

  Eigen::Vector3d low, high;
  for (int axis = 0; axis < 3; ++axis) {
    auto& values = coordinates[static_cast<std::size_t>(axis)];
    low[axis] = quantile(values, 0.01);
    high[axis] = quantile(values, 0.99);
  }
  report.robust_bounds = {low, high};
  report.robust_diagonal = (high - low).norm();
  const double giant = kGiantShare * report.robust_diagonal;
  if (giant > 0.0)
    report.giant = static_cast<std::size_t>(
        std::count_if(longest.begin(), longest.end(), [&](double s) { return s > giant; }));
  for (std::size_t k = 0; k < kPaperThresholds.size(); ++k) {
    const auto above =
        std::count_if(opacity.begin(), opacity.end(), [&](double a) { return a > kPaperThresholds[k]; });
    report.share_above[k] = static_cast<double>(above) / static_cast<double>(report.total);
  }
  report.opacity = quantiles(opacity);
  report.longest_sigma = quantiles(longest);
  report.shortest_sigma = quantiles(shortest);
  return report;
}

}  // namespace palpate

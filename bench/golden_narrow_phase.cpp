#include "golden_narrow_phase.h"

#include <numbers>

#include <palpate/collision/contact.h>
#include <palpate/collision/paper_pipeline.h>

namespace palpate::bench {
namespace {

/// Minimum of K by golden-section search: K at the middle of the last bracket.
double golden_minimum(const KFunction& k) {
  constexpr double kShrink = 1.0 / std::numbers::phi;
  double begin = 0.0, width = 1.0;
  double inner_left = k(1.0 - kShrink), inner_right = k(kShrink);
  for (int i = 0; i < PaperPipeline::kDefaultIterations; ++i) {
    width *= kShrink;
    if (inner_left < inner_right) {
      inner_right = inner_left;
      inner_left = k(begin + width * (1.0 - kShrink));
    } else {
      begin += width * (1.0 / kShrink - 1.0);
      inner_left = inner_right;
      inner_right = k(begin + width * kShrink);
    }
  }
  return k(begin + 0.5 * width);
}

bool boxes_overlap(const Ellipsoid& gaussian, const Ellipsoid& tool, const Eigen::Vector3d& tool_half) {
  constexpr double kRounding = 1.0 + 1e-12;
  const Eigen::Array3d reach = kRounding * (gaussian.half_extents() + tool_half);
  return ((gaussian.center - tool.center).array().abs() <= reach).all();
}

}  // namespace

GoldenNarrowPhase::GoldenNarrowPhase(const EllipsoidScene& scene)
    : ellipsoids_(scene.ellipsoids), id_(scene.id) {
  radius_.reserve(scene.size());
  for (const Ellipsoid& e : scene.ellipsoids) radius_.push_back(e.radius());
}

GoldenNarrowPhase::Query::Query(GoldenNarrowPhase& phase, const Ellipsoid& tool)
    : phase_(phase), tool_(tool), tool_radius_(tool.radius()), tool_half_(tool.half_extents()) {
  phase_.hits_.clear();
}

void GoldenNarrowPhase::Query::test(std::size_t i) {
  const Ellipsoid& gaussian = phase_.ellipsoids_[i];
  if (!spheres_overlap(gaussian, phase_.radius_[i], tool_.ellipsoid, tool_radius_)) return;
  if (!boxes_overlap(gaussian, tool_.ellipsoid, tool_half_)) return;
  const double k_min = golden_minimum(KFunction(tool_, gaussian));
  if (k_min > 0.0) phase_.hits_.push_back({phase_.id_[i], k_min});
}

}  // namespace palpate::bench

#include <palpate/collision/paper_pipeline.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <nanoflann.hpp>

#include <palpate/base/quantile.h>

namespace palpate {
namespace {

/// Adapter of the centres of a scene for nanoflann.
struct Centers {
  const std::vector<Ellipsoid>& ellipsoids;

  std::size_t kdtree_get_point_count() const { return ellipsoids.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return ellipsoids[i].center[static_cast<int>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

/// Result set for nanoflann: the points within a radius, unsorted. Those of nanoflann differ between versions
/// 1.4 (Debian 12) and 1.7 (Debian 13).
class PointsWithin {
 public:
  using DistanceType = double;

  PointsWithin(double squared_radius, std::vector<std::uint32_t>& found)
      : squared_radius_(squared_radius), found_(found) {}

  bool full() const { return true; }
  double worstDist() const { return squared_radius_; }
  void sort() {}
  /// \returns true: go on.
  bool addPoint(double squared_distance, std::uint32_t i) {
    if (squared_distance < squared_radius_) found_.push_back(i);
    return true;
  }

 private:
  double squared_radius_;
  std::vector<std::uint32_t>& found_;
};

/// Least K over [0, 1] after `iterations` golden sections (paper III-B2).
KMinimum golden_section(const KFunction& k, int iterations) {
  constexpr double kRatio = 1.0 / std::numbers::phi;
  double low = 0.0, high = 1.0;
  double left = high - kRatio * (high - low), right = low + kRatio * (high - low);
  double k_left = k(left), k_right = k(right);
  for (int i = 0; i < iterations; ++i) {
    if (k_left < k_right) {
      high = std::exchange(right, left);
      k_right = k_left;
      left = high - kRatio * (high - low);
      k_left = k(left);
    } else {
      low = std::exchange(left, right);
      k_left = k_right;
      right = low + kRatio * (high - low);
      k_right = k(right);
    }
  }
  const double lambda = 0.5 * (low + high);
  const double log_t = std::log(lambda) - std::log1p(-lambda);  // infinite if lambda rounds to 1
  return {k(lambda), lambda, std::clamp(log_t, -kMaxLogT, kMaxLogT)};
}

}  // namespace

struct PaperPipeline::Tree {
  using Index = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Centers>, Centers, 3,
                                                    std::uint32_t>;

  explicit Tree(const std::vector<Ellipsoid>& ellipsoids) : centers{ellipsoids}, index(3, centers) {
    index.buildIndex();
  }

  Centers centers;
  Index index;
};

PaperPipeline::PaperPipeline(EllipsoidScene scene, double search_radius, int iterations)
    : scene_(std::move(scene)), search_radius_(search_radius), iterations_(iterations) {
  radius_.reserve(scene_.size());
  for (const Ellipsoid& e : scene_.ellipsoids) radius_.push_back(e.radius());
  tree_ = std::make_unique<Tree>(scene_.ellipsoids);
}

PaperPipeline::~PaperPipeline() = default;

void PaperPipeline::query(const Ellipsoid& tool, ContactSet& result) const {
  result.clear();
  if (scene_.size() == 0) return;
  std::vector<std::uint32_t> found;
  PointsWithin within(search_radius_ * search_radius_, found);
  tree_->index.findNeighbors(within, tool.center.data(), {});
  result.candidates = found.size();

  const WhitenedTool whitened(tool);
  const double tool_radius = tool.radius();
  for (const std::uint32_t i : found) {
    const Ellipsoid& gaussian = scene_.ellipsoids[i];
    if (!spheres_overlap(gaussian, radius_[i], tool, tool_radius)) continue;
    ++result.filtered;
    const KFunction k(whitened, gaussian);
    const KMinimum minimum = golden_section(k, iterations_);
    if (!(minimum.k_min > 0.0)) continue;
    Contact& contact = result.contacts.emplace_back(make_contact(whitened, gaussian, k, minimum));
    contact.id = scene_.id[i];
    contact.opacity = scene_.opacity[i];
  }
  std::sort(result.contacts.begin(), result.contacts.end(),
            [](const Contact& a, const Contact& b) { return a.id < b.id; });
}

std::size_t PaperPipeline::can_miss(double tool_radius) const {
  return static_cast<std::size_t>(std::count_if(radius_.begin(), radius_.end(),
                                                [&](double r) { return r + tool_radius > search_radius_; }));
}

double PaperPipeline::default_search_radius(const EllipsoidScene& scene, double tool_radius) {
  std::vector<double> radii;
  radii.reserve(scene.size());
  for (const Ellipsoid& e : scene.ellipsoids) radii.push_back(e.radius());
  return quantile(radii, 0.99) + tool_radius;
}

}  // namespace palpate

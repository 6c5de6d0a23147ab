#include "truth.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <support/k_oracle.h>

namespace palpate::bench {
namespace {

using test::PairOracle;
using test::Solid;

double bounding_radius(const Ellipsoid& e) {
  constexpr double kMargin = 1.0 + 1e-12;  // larger than any rounding of lengths: no contact may be lost here
  return kMargin * e.axes.colwise().norm().maxCoeff();
}

/// Poses sorted by x, so that those within reach of a Gaussian are a short range.
class Sweep {
 public:
  explicit Sweep(const std::vector<Ellipsoid>& tools) : order_(tools.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::sort(order_.begin(), order_.end(),
              [&](std::size_t a, std::size_t b) { return tools[a].center[0] < tools[b].center[0]; });
    for (const std::size_t i : order_) {
      center_.push_back(tools[i].center);
      solid_.emplace_back(tools[i]);
      radius_ = std::max(radius_, bounding_radius(tools[i]));
    }
  }

  /// Calls visit(pose, solid) for every pose whose bounding sphere meets that of `gaussian`.
  template <typename Visit>
  void each_near(const Ellipsoid& gaussian, const Visit& visit) const {
    const double reach = radius_ + bounding_radius(gaussian);
    const auto before = [](const Eigen::Vector3d& p, double x) { return p[0] < x; };
    auto at = std::lower_bound(center_.begin(), center_.end(), gaussian.center[0] - reach, before);
    for (; at != center_.end() && (*at)[0] <= gaussian.center[0] + reach; ++at) {
      if ((*at - gaussian.center).squaredNorm() > reach * reach) continue;
      const auto i = static_cast<std::size_t>(at - center_.begin());
      visit(order_[i], solid_[i]);
    }
  }

 private:
  std::vector<std::size_t> order_;
  std::vector<Eigen::Vector3d> center_;    // in the order of order_
  std::vector<Solid<long double>> solid_;  // likewise
  double radius_ = 0.0;                    // of the largest tool
};

struct PosedHit {
  std::size_t pose;
  Hit hit;
};

bool by_id(const Hit& a, const Hit& b) { return a.id < b.id; }

}  // namespace

struct TruthFinder::Parts {
  explicit Parts(const std::vector<Ellipsoid>& tools) : sweep(tools), truth(tools.size()) {}

  const Sweep sweep;
  Truth truth;
};

TruthFinder::TruthFinder(const std::vector<Ellipsoid>& tools) : parts_(std::make_unique<Parts>(tools)) {}
TruthFinder::~TruthFinder() = default;

void TruthFinder::add(const EllipsoidScene& scene) {
  tbb::enumerable_thread_specific<std::vector<PosedHit>> found;
  tbb::parallel_for(std::size_t{0}, scene.size(), [&](std::size_t i) {
    std::optional<Solid<long double>> gaussian;  // computed on demand: most are near no pose
    parts_->sweep.each_near(scene.ellipsoids[i], [&](std::size_t pose, const Solid<long double>& tool) {
      if (!gaussian) gaussian.emplace(scene.ellipsoids[i]);
      const long double k = PairOracle<long double>(tool, *gaussian).k_min(0.0L);
      if (k > 0.0L) found.local().push_back({pose, {scene.id[i], static_cast<double>(k)}});
    });
  });
  for (const std::vector<PosedHit>& part : found)
    for (const PosedHit& posed : part) parts_->truth[posed.pose].push_back(posed.hit);
}

Truth TruthFinder::take() {
  for (std::vector<Hit>& hits : parts_->truth) std::sort(hits.begin(), hits.end(), by_id);
  return std::move(parts_->truth);
}

void Accuracy::add(const std::vector<Hit>& truth, std::vector<Hit>& found) {
  std::sort(found.begin(), found.end(), by_id);
  auto t = truth.begin();
  auto f = found.begin();
  while (t != truth.end() || f != found.end()) {
    if (f == found.end() || (t != truth.end() && t->id < f->id)) {
      ++misses;
      worst_missed = std::max(worst_missed, (t++)->k_min);
    } else if (t == truth.end() || f->id < t->id) {
      ++extras;
      ++f;
    } else {
      const double error = std::abs((t++)->k_min - (f++)->k_min);
      worst_k = std::isnan(error) ? error : std::max(error, worst_k);
    }
  }
}

}  // namespace palpate::bench

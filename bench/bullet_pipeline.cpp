// Bullet: the dynamic bounding volume tree of its broad phase, then the paper's narrow phase.
#include <cmath>
#include <limits>

#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include "golden_narrow_phase.h"
#include "pipeline.h"

namespace palpate::bench {
namespace {

/// Bounding box of an ellipsoid in Bullet's single precision, widened by one step against rounding.
btDbvtVolume bounds(const Ellipsoid& e) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const Eigen::Vector3d half = e.half_extents();
  btVector3 low, high;
  for (int k = 0; k < 3; ++k) {
    low[k] = std::nextafter(static_cast<float>(e.center[k] - half[k]), -kInfinity);
    high[k] = std::nextafter(static_cast<float>(e.center[k] + half[k]), kInfinity);
  }
  return btDbvtVolume::FromMM(low, high);
}

struct Collide final : btDbvt::ICollide {
  explicit Collide(GoldenNarrowPhase::Query& into) : query(into) {}
  void Process(const btDbvtNode* leaf) override { query.test(static_cast<std::size_t>(leaf->dataAsInt)); }

  GoldenNarrowPhase::Query& query;
};

class Bullet final : public Pipeline {
 public:
  explicit Bullet(const PipelineInput& input) : narrow_(input.ellipsoids) {
    const std::vector<Ellipsoid>& ellipsoids = narrow_.ellipsoids();
    for (std::size_t i = 0; i < ellipsoids.size(); ++i) {
      tree_.insert(bounds(ellipsoids[i]), nullptr)->dataAsInt = static_cast<int>(i);
    }
  }

  std::string name() const override { return "Bullet btDbvt"; }
  void query(const Ellipsoid& tool) override {
    GoldenNarrowPhase::Query query(narrow_, tool);
    Collide collide(query);
    tree_.collideTV(tree_.m_root, bounds(tool), collide);
  }
  void hits(std::vector<Hit>& out) const override { out = narrow_.hits(); }

 private:
  GoldenNarrowPhase narrow_;
  btDbvt tree_;
};

}  // namespace

Pipelines build_bullet(const PipelineInput& input) { return only<Bullet>(input); }

}  // namespace palpate::bench

// FCL: its dynamic AABB tree and the GJK of libccd on its ellipsoids, as in its documentation. It reports
// whether a pair overlaps, but no K.
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/narrowphase/collision.h>

#include "pipeline.h"

namespace palpate::bench {
namespace {

using Object = fcl::CollisionObject<double>;

/// Collision object with the principal axes as rotation. \pre the semi-axes are positive.
Object make_object(const Ellipsoid& e) {
  const Eigen::Vector3d semi_axes = e.axes.colwise().norm().transpose();
  fcl::Transform3d pose = fcl::Transform3d::Identity();
  pose.linear() = e.axes * semi_axes.cwiseInverse().asDiagonal();
  pose.translation() = e.center;
  return Object(std::make_shared<fcl::Ellipsoidd>(semi_axes), pose);
}

/// Collects the objects that overlap the tool.
struct Collector {
  const Object* tool;
  std::vector<const Object*>& overlapping;

  static bool test(Object* a, Object* b, void* self) {
    auto& [tool, overlapping] = *static_cast<Collector*>(self);
    const fcl::CollisionRequestd request;
    fcl::CollisionResultd result;
    fcl::collide(a, b, request, result);
    if (result.isCollision()) overlapping.push_back(a == tool ? b : a);
    return false;  // continue
  }
};

class Fcl final : public Pipeline {
 public:
  explicit Fcl(const PipelineInput& input) : id_(input.ellipsoids.id) {
    objects_.reserve(input.ellipsoids.size());
    std::vector<Object*> pointers;
    pointers.reserve(input.ellipsoids.size());
    for (const Ellipsoid& e : input.ellipsoids.ellipsoids) {
      pointers.push_back(&objects_.emplace_back(make_object(e)));
    }
    tree_.registerObjects(pointers);
    tree_.setup();
  }

  std::string name() const override { return "FCL + libccd"; }
  void query(const Ellipsoid& tool) override {
    overlapping_.clear();
    Object object = make_object(tool);
    Collector collector{&object, overlapping_};
    tree_.collide(&object, &collector, Collector::test);
  }
  void hits(std::vector<Hit>& out) const override {
    out.clear();
    for (const Object* object : overlapping_)
      out.push_back({id_[static_cast<std::size_t>(object - objects_.data())]});
  }

 private:
  std::vector<std::uint32_t> id_;
  std::vector<Object> objects_;
  fcl::DynamicAABBTreeCollisionManagerd tree_;
  std::vector<const Object*> overlapping_;
};

}  // namespace

Pipelines build_fcl(const PipelineInput& input) { return only<Fcl>(input); }

}  // namespace palpate::bench

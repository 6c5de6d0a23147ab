#include <palpate/haptics/anchored_scene.h>

#include <cmath>

namespace palpate {

bool AnchoredScene::follow() {
  if (index_.epoch() == epoch_) return true;
  epoch_ = index_.epoch();
  const Similarity &now = index_.world_from_scene(), &then = scene_.world_from_scene();
  const bool is_rigid =
      now.mirrored == then.mirrored && std::abs(now.scale - then.scale) <= kSameScale * then.scale;
  if (is_rigid && index_.shares_memory_with(scene_)) {
    X_WA_.orientation = (now.rotation * then.rotation.conjugate()).normalized();
    X_WA_.position = now.translation - X_WA_.orientation * then.translation;
    has_moved_ = X_WA_ != Pose{};
    return true;
  }
  const Eigen::Quaterniond back = X_WA_.orientation.conjugate();
  scene_ = has_moved_ ? index_.registered({now.scale, back * now.rotation,
                                           back * (now.translation - X_WA_.position), now.mirrored})
                      : index_;
  return false;
}

}  // namespace palpate

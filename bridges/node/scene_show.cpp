#include "scene_show.h"

#include <chrono>
#include <exception>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "node_scenes.h"

namespace palpate::node {

SceneShow::SceneShow(const LiveSystem& first, int decimation, NodeSink& sink, NodeNotices& notices)
    : first_(first),
      decimation_(decimation),
      sink_(sink),
      notices_(notices),
      looked_at_(first.felt()->index()),
      name_(felt_name(first)) {
  if (!publish(make(looked_at_, decimation_))) say_no_memory();
}

void SceneShow::update() {
  if (making_.valid()) {
    if (making_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    const Made made = making_.get();
    std::string name = felt_name(first_);
    if (!publish(made)) say_no_memory();
    if (name != name_) notices_.say(fmt::format("{} is active", name));
    name_ = std::move(name);
  }
  std::shared_ptr<const SceneIndex> felt = first_.felt()->index();
  if (felt == looked_at_) return;
  looked_at_ = std::move(felt);
  try {
    making_ = std::async(std::launch::async, make, looked_at_, decimation_);
  } catch (const std::exception&) {  // no memory or no thread
    say_no_memory();
  }
}

void SceneShow::say_no_memory() {
  notices_.say(
      fmt::format("warning: {}: not enough memory to publish its centres and contacts", felt_name(first_)));
}

SceneShow::Made SceneShow::make(const std::shared_ptr<const SceneIndex>& index, int decimation) {
  try {
    Made made{std::make_shared<const ShownScene>(index), {}};
    const EllipsoidScene all = made.scene->ellipsoids.all();
    const auto step = static_cast<std::size_t>(decimation);
    for (std::size_t i = 0; i < all.ellipsoids.size(); i += step) {
      const Eigen::Vector3f center = all.ellipsoids[i].center.cast<float>();
      made.centers.insert(made.centers.end(), center.begin(), center.end());
    }
    return made;
  } catch (const std::bad_alloc&) {
    return {};
  }
}

/// \returns false if there is not enough memory
bool SceneShow::publish(const Made& made) {
  if (!made.scene) return false;
  try {
    sink_.publish_centers(made.centers);
  } catch (const std::bad_alloc&) {
    return false;
  }
  scene_ = made.scene;
  return true;
}

}  // namespace palpate::node

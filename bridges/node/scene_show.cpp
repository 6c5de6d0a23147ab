#include "scene_show.h"

#include <chrono>
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
  publish(make(looked_at_, decimation_));
}

void SceneShow::update() {
  if (making_.valid()) {
    if (making_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    const Made made = making_.get();
    publish(made);
    std::string name = felt_name(first_);
    if (!made.scene)
      notices_.say(fmt::format("warning: {}: not enough memory to publish its centres and contacts", name));
    if (name != name_) notices_.say(fmt::format("{} is active", name));
    name_ = std::move(name);
  }
  std::shared_ptr<const SceneIndex> felt = first_.felt()->index();
  if (felt == looked_at_) return;
  looked_at_ = std::move(felt);
  making_ = std::async(std::launch::async, make, looked_at_, decimation_);
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

void SceneShow::publish(const Made& made) {
  scene_ = made.scene;
  sink_.publish_centers(made.centers);
}

}  // namespace palpate::node

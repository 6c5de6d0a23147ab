/// \file
/// The scene that a node shows.
#pragma once

#include <future>
#include <memory>
#include <string>
#include <vector>

#include <palpate/collision/ellipsoid_lookup.h>
#include <palpate/live/live_system.h>

#include "node_notices.h"
#include "node_sink.h"

namespace palpate::node {

/// What is felt, with its ellipsoids by their ids. Immutable.
struct ShownScene {
  explicit ShownScene(std::shared_ptr<const SceneIndex> felt) : index(std::move(felt)), ellipsoids(*index) {}

  std::shared_ptr<const SceneIndex> index;
  EllipsoidLookup ellipsoids;
};

/// Follows the first hand from scene to scene: publishes the centres of what can be felt, in the world, and
/// has the ellipsoids for those who show contacts. One thread; what takes long is done on another.
class SceneShow {
 public:
  /// Publishes the first scene. All must outlive it. \param first has started \param decimation of the
  /// centres, every how manieth is published
  SceneShow(const LiveSystem& first, int decimation, NodeSink& sink, NodeNotices& notices);

  /// Publishes another scene once it is felt and has been looked through; says which file it is.
  void update();
  /// The one that was published last.
  const std::shared_ptr<const ShownScene>& scene() const { return scene_; }

 private:
  struct Made {
    std::shared_ptr<const ShownScene> scene;  ///< null: there is not enough memory for it
    std::vector<float> centers;
  };
  static Made make(const std::shared_ptr<const SceneIndex>& index, int decimation);
  void publish(const Made& made);

  const LiveSystem& first_;
  int decimation_;
  NodeSink& sink_;
  NodeNotices& notices_;
  std::shared_ptr<const ShownScene> scene_;
  std::shared_ptr<const SceneIndex> looked_at_;  ///< of what is made, or was made last
  std::string name_;                             ///< of the scene that was felt then
  std::future<Made> making_;
};

}  // namespace palpate::node

/// \file
/// Publication of the scene of a node.
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

/// The current scene, with a lookup of its ellipsoids by id. Immutable.
struct ShownScene {
  explicit ShownScene(std::shared_ptr<const SceneIndex> felt) : index(std::move(felt)), ellipsoids(*index) {}

  std::shared_ptr<const SceneIndex> index;
  EllipsoidLookup ellipsoids;
};

/// Tracks the scene of the first hand: publishes the centres of its Gaussians in the world frame, and
/// provides its ellipsoids for the display of contacts. One thread; long work runs on another.
class SceneShow {
 public:
  /// Publishes the initial scene; reports it if there is not enough memory. The references must outlive this.
  /// \param first a started system \param decimation every n-th centre is published
  SceneShow(const LiveSystem& first, int decimation, NodeSink& sink, NodeNotices& notices);

  /// Publishes a new scene once it is felt and its lookup is built; reports its name. If there is not enough
  /// memory, reports that, and what was published stays.
  void update();
  /// The scene published last.
  const std::shared_ptr<const ShownScene>& scene() const { return scene_; }

 private:
  struct Made {
    std::shared_ptr<const ShownScene> scene;  ///< null if there is not enough memory
    std::vector<float> centers;
  };
  static Made make(const std::shared_ptr<const SceneIndex>& index, int decimation);
  bool publish(const Made& made);
  void say_no_memory();

  const LiveSystem& first_;
  int decimation_;
  NodeSink& sink_;
  NodeNotices& notices_;
  std::shared_ptr<const ShownScene> scene_;
  std::shared_ptr<const SceneIndex> looked_at_;  ///< index of the scene in the making, or made last
  std::string name_;                             ///< name of the scene published last
  std::future<Made> making_;
};

}  // namespace palpate::node

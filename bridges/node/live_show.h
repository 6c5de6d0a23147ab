/// \file
/// Publication of the hands of a node.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include <palpate/gateway/contact_markers.h>
#include <palpate/gateway/crtk_device.h>
#include <palpate/gateway/diagnostics.h>
#include <palpate/live/live_system.h>
#include <palpate/servo/live_view.h>

#include "node_notices.h"
#include "node_recording.h"
#include "node_settings.h"
#include "node_sink.h"
#include "scene_show.h"

namespace palpate::node {

/// A hand to publish. The references must outlive this.
struct ShownHand {
  std::size_t number = 0;  ///< index in the sink
  const NodeHand& settings;
  LiveSystem& system;
  const CrtkDevice& device;  ///< device of `system`
  LiveView& view;
  NodeNotices& notices;
  NodeRecording& recording;
};

/// Publishes contacts, tool, transforms and status of a hand at its newest tick. One thread.
class LiveShow {
 public:
  static constexpr double kRate = 30.0;        ///< rate of update(). Unit: [Hz].
  static constexpr int kDiagnosticsEvery = 3;  ///< number of updates per publication of diagnostics

  /// \param tf_prefix prefix of frame names \param sink must outlive it
  LiveShow(const ShownHand& hand, const std::string& tf_prefix, NodeSink& sink);

  /// Reads the newest tick, publishes its contacts and tool, and reports failures. \param scene the published
  /// scene, or null; no contacts are published while the hand feels another scene
  void update(const ShownScene* scene);
  /// Appends the hand's frames to `all`.
  void add_transforms(std::vector<SinkTransform>& all) const;
  /// Appends the status of the loop, the device and the scene to `all`.
  void add_statuses(std::vector<SinkStatus>& all);

 private:
  /// Returns whether this is the first hand, which publishes the scene's frame.
  bool is_first() const { return hand_.settings.name.empty(); }
  SinkStatus servo_status(std::string name) const;
  SinkStatus device_status(std::string name, double now);
  SinkStatus scene_status(std::string name) const;
  void publish_contacts(const ShownScene& scene);
  void say_failures();

  ShownHand hand_;
  std::string frames_;  ///< prefix of the names of the hand's frames
  NodeSink& sink_;
  std::shared_ptr<const FeltScene> felt_;
  ContactSet found_;
  ContactMarkers contacts_;
  RateWatch watch_;
  std::uint64_t dropped_ = 0;  ///< number of dropped poses at the last status
  double dropped_at_ = -1e9;   ///< time of its last increase. Unit: [s].
  std::uint64_t said_ = 0;     ///< LiveSystem::version() of the last reported failure
};

/// Publishes all hands at their newest ticks. \param diagnostics whether to publish diagnostics too
void publish(std::deque<LiveShow>& shows, const ShownScene* scene, NodeSink& sink, bool diagnostics);

}  // namespace palpate::node

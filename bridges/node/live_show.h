/// \file
/// What a node shows of its hands.
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

/// A hand that is shown. All that it refers to must outlive who has it.
struct ShownHand {
  std::size_t number = 0;  ///< in the sink
  const NodeHand& settings;
  LiveSystem& system;
  const CrtkDevice& device;  ///< of `system`
  LiveView& view;
  NodeNotices& notices;
  NodeRecording& recording;
};

/// Publishes what a hand feels, at its newest tick. One thread.
class LiveShow {
 public:
  static constexpr double kRate = 30.0;        ///< of update(). Unit: [Hz].
  static constexpr int kDiagnosticsEvery = 3;  ///< of update(), how many to one of diagnostics

  /// \param tf_prefix of names of frames \param sink must outlive it
  LiveShow(const ShownHand& hand, const std::string& tf_prefix, NodeSink& sink);

  /// Has the newest tick, and publishes contacts and tool at it. Says what has failed. \param scene that is
  /// shown, null for none: there are no contacts while the hand feels another
  void update(const ShownScene* scene);
  /// Its frames go to `all`.
  void add_transforms(std::vector<SinkTransform>& all) const;
  /// The states of its loop, its device and what it is doing go to `all`.
  void add_statuses(std::vector<SinkStatus>& all);

 private:
  /// Which tells the scene's frame.
  bool is_first() const { return hand_.settings.name.empty(); }
  SinkStatus servo_status(std::string name) const;
  SinkStatus device_status(std::string name, double now);
  SinkStatus scene_status(std::string name) const;
  void publish_contacts(const ShownScene& scene);
  void say_failures();

  ShownHand hand_;
  std::string frames_;  ///< before the names of the hand's own
  NodeSink& sink_;
  std::shared_ptr<const FeltScene> felt_;
  ContactSet found_;
  ContactMarkers contacts_;
  RateWatch watch_;
  std::uint64_t dropped_ = 0;  ///< poses, when they were counted last
  double dropped_at_ = -1e9;   ///< when that last rose. Unit: [s].
  std::uint64_t said_ = 0;     ///< LiveSystem::version() of the failure that was said last
};

/// All hands, at their newest ticks. \param diagnostics these too
void publish(std::deque<LiveShow>& shows, const ShownScene* scene, NodeSink& sink, bool diagnostics);

}  // namespace palpate::node

/// \file
/// What a node shows of a live system.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <palpate/collision/ellipsoid_lookup.h>
#include <palpate/gateway/contact_markers.h>
#include <palpate/gateway/crtk_device.h>
#include <palpate/gateway/diagnostics.h>
#include <palpate/live/live_system.h>
#include <palpate/servo/live_view.h>

#include "node_notices.h"
#include "node_settings.h"
#include "node_sink.h"

namespace palpate::node {

/// Publishes what a system feels, at its newest tick. One thread.
class LiveShow {
 public:
  static constexpr double kRate = 30.0;        ///< of publish(). Unit: [Hz].
  static constexpr int kDiagnosticsEvery = 3;  ///< of publish(), how many to one of diagnostics

  /// All must outlive it. \param device of `system`
  LiveShow(LiveSystem& system, const CrtkDevice& device, LiveView& view, const NodeNotices& notices,
           const NodeSettings& settings, NodeSink& sink);

  /// The centres of what can be felt, in the world.
  void publish_centers();
  /// \param now of the system's clock. Unit: [s].
  void publish(double now);

 private:
  void publish_contacts(const TickRecord& tick);
  void publish_transforms(const TickRecord& tick);
  SinkStatus servo_status(const TickRecord& tick) const;
  SinkStatus device_status(const TickRecord& tick, double now);

  LiveSystem& system_;
  const CrtkDevice& device_;
  LiveView& view_;
  const NodeNotices& notices_;
  const NodeSettings& settings_;
  NodeSink& sink_;
  std::shared_ptr<const FeltScene> felt_;
  EllipsoidLookup ellipsoids_;
  ContactSet found_;
  ContactMarkers contacts_;
  RateWatch watch_;
  int count_ = 0;
  std::uint64_t dropped_ = 0;  ///< poses, when they were counted last
  double dropped_at_ = -1e9;   ///< when that last rose. Unit: [s].
};

}  // namespace palpate::node

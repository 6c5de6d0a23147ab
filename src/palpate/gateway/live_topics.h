/// \file
/// What a loop does, as topics.
#pragma once

#include <array>
#include <memory>
#include <string>

#include <palpate/collision/scene_index.h>
#include <palpate/gateway/client_hand.h>
#include <palpate/gateway/contact_markers.h>
#include <palpate/gateway/tick_feed.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/rosbridge/hub.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// The topics under /palpate that tell what is felt, and the hand of a client. Belongs to the gateway's
/// thread.
class LiveTopics {
 public:
  /// All must outlive it. \param map where poses of a client that are not in the frame "world" are
  LiveTopics(Hub& hub, TickFeed& feed, ClientHand& hand, const LoopClock& clock,
             const LoopStatistics& statistics, const WorkspaceMap& map, bool client_is_device);

  /// What is felt from now on, and what with.
  void feel(std::shared_ptr<const SceneIndex> index, const Tool& tool);

  /// Called kRate times a second.
  void publish();
  /// Called when feed.wake() is set: the answers to a client's pose.
  void answer();

  static constexpr double kRate = 60.0;  ///< Unit: [Hz].
  /// Of publish(), how many to a message of contacts, and of diagnostics.
  static constexpr int kContactsEvery = 2, kDiagnosticsEvery = 3;
  /// A client that is silent for longer holds nothing. Unit: [s].
  static constexpr double kSilence = 1.0;

  bool is_held() const { return holder_ != nullptr; }

 private:
  void take(const Json& message, Client& from);
  void release();
  void publish_wrenches(const Stamp& stamp, Client* only);
  void publish_contacts(const Stamp& stamp);
  void publish_tool(const Stamp& stamp);
  void publish_diagnostics(const Stamp& stamp);
  void watch_rate();

  Hub& hub_;
  TickFeed& feed_;
  ClientHand& hand_;
  const LoopClock& clock_;
  const LoopStatistics& statistics_;
  WorkspaceMap map_;
  bool client_is_device_;
  Topic &pose_, &velocity_, &spatial_, &body_, &proxy_, &contacts_, &tool_topic_, &diagnostics_, &client_;

  std::shared_ptr<const SceneIndex> index_;
  std::unique_ptr<EllipsoidLookup> ellipsoids_;  ///< made when someone wants to see contacts
  Tool tool_;
  ContactSet found_;
  ContactMarkers markers_;

  Client* holder_ = nullptr;  ///< whose hand it is
  double held_at_ = 0.0;      ///< when it spoke last. Unit: [s].
  /// Of its last poses, by number.
  std::array<Stamp, 256> stamps_;
  std::uint64_t answered_ = 0;  ///< number of a pose
  std::uint64_t count_ = 0;     ///< calls of publish()
  std::uint64_t ticks_ = 0;
  double ticks_at_ = 0.0, rate_ = 0.0;
};

}  // namespace palpate

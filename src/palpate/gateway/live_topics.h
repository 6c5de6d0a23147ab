/// \file
/// What a loop does, as topics.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include <palpate/collision/ellipsoid_lookup.h>
#include <palpate/collision/scene_index.h>
#include <palpate/gateway/client_clock.h>
#include <palpate/gateway/client_hand.h>
#include <palpate/gateway/contact_markers.h>
#include <palpate/gateway/diagnostics.h>
#include <palpate/gateway/tick_feed.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/rosbridge/elsewhere.h>
#include <palpate/rosbridge/hub.h>
#include <palpate/rosbridge/ros_message.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// The topics of a hand that tell what is felt, and where a client says it is. Belongs to the gateway's
/// thread.
class LiveTopics {
 public:
  /// All must outlive it. \param map where the device is in the world, until a tick says where it is now
  /// \param prefix of their names
  LiveTopics(Hub& hub, TickFeed& feed, ClientHand& hand, const LoopClock& clock,
             const LoopStatistics& statistics, const WorkspaceMap& map, bool client_is_device,
             const std::string& prefix = "/palpate");

  /// Called where another client than before takes a device that is one: the force must fall before its hand
  /// is felt.
  std::function<void()> on_other_hand;
  /// A pose that is older when it comes is dropped. Unit: [s].
  double stale_after = SafetyLimits().stale_after;

  /// Who does what takes long: at once, where nobody else is told to.
  Elsewhere elsewhere = [](auto work, auto then) {
    work();
    then();
  };

  /// What is felt from now on, and what with.
  void feel(std::shared_ptr<const SceneIndex> index, const Tool& tool);

  /// Called kRate times a second.
  void publish();
  /// Called when feed.wake() is set: the force of a tick, for the client whose hand it is.
  void answer();

  static constexpr double kRate = 60.0;  ///< Unit: [Hz].
  /// Of publish(), how many to a message of contacts, and of diagnostics.
  static constexpr int kContactsEvery = 2, kDiagnosticsEvery = 3, kEchoEvery = 6;
  /// A client that is silent for longer holds nothing. Unit: [s].
  static constexpr double kSilence = 1.0;

  /// The tool where it was last, and what the device is sent there, world frame.
  const Tool& tool() const { return tool_; }
  const TickRecord& newest() const { return feed_.newest().record; }
  bool is_held() const { return holder_ != nullptr; }
  /// As if who holds the tool were silent: until it sends again, nobody does.
  void let_go() {
    if (holder_ != nullptr) release();
  }

 private:
  void take(const Json& message, Client& from);
  /// When a pose was measured that came at `now`; nothing if it is too old. \throws Refusal now and then
  /// where it is, for the client to be told.
  std::optional<double> measured_at(const Stamp& stamp, double now);
  void hold(Client& client);
  void release();
  void ask_echo();
  void take_echo(const Json& message, const Client& from);
  /// The newest pose goes on to the loop, once no force is on that was for another hand.
  void hand_over();
  /// At the newest tick.
  void look();
  bool force_has_fallen() const;
  void publish_device_wrench(const Wrench& wrench);
  /// \param share of the governor, 0 where nothing is to be felt
  void publish_local_model(double share);
  void publish_world_wrenches(const Stamp& stamp, Client* only);
  void publish_contacts(const Stamp& stamp);
  void look_up_ellipsoids();
  void publish_tool(const Stamp& stamp);
  void publish_diagnostics(const Stamp& stamp);

  Hub& hub_;
  TickFeed& feed_;
  ClientHand& hand_;
  const LoopClock& clock_;
  RateWatch watch_;
  WorkspaceMap map_;
  bool client_is_device_;
  std::string status_;  ///< what diagnostics call it
  Topic &pose_, &velocity_, &spatial_, &body_, &proxy_, &contacts_, &tool_topic_, &diagnostics_, &client_,
      &local_model_, &echo_;

  std::shared_ptr<const SceneIndex> index_;
  /// Of an index; made when someone wants to see contacts.
  struct Lookup {
    std::shared_ptr<const SceneIndex> index;
    std::unique_ptr<EllipsoidLookup> ellipsoids;
  };
  std::shared_ptr<const Lookup> lookup_;
  bool looking_up_ = false;
  Tool tool_;
  ContactSet found_;
  ContactMarkers markers_;

  Client* holder_ = nullptr;  ///< whose hand it is
  double held_at_ = 0.0;      ///< when it spoke last. Unit: [s].
  /// Since when it waits for the force to fall that another hand had; unset: it does not. Unit: [s].
  std::optional<double> waits_since_;
  bool was_held_ = false;  ///< by anybody
  ClientClock holder_clock_;
  double told_late_ = -std::numeric_limits<double>::infinity();  ///< Unit: [s].
  struct Waiting {
    DevicePose device;
    double t = 0.0;  ///< Unit: [s].
    Stamp stamp;
  };
  std::optional<Waiting> waiting_;  ///< its newest pose, while more of what it has sent may be there
  bool told_ = false;               ///< it was sent the force since publish()
  /// Of its last poses, by number.
  std::array<Stamp, 256> stamps_;
  std::uint64_t answered_ = 0;  ///< number of a pose
  std::uint64_t count_ = 0;     ///< calls of publish()
};

}  // namespace palpate

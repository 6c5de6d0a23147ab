/// \file
/// Topics of a servo loop: state published to clients, and poses received from them.
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

/// Publishes the contact state of a hand, and receives the poses of the client that holds it. Used on the
/// gateway thread.
class LiveTopics {
 public:
  /// All references must outlive it. \param map from the device to the world, until the first tick provides
  /// it \param prefix of the topic names
  LiveTopics(Hub& hub, TickFeed& feed, ClientHand& hand, const LoopClock& clock,
             const LoopStatistics& statistics, const WorkspaceMap& map, bool client_is_device,
             const std::string& prefix = "/palpate");

  /// Called when another client takes over a client device: the force must ramp to zero before its poses are
  /// used.
  std::function<void()> on_other_hand;
  /// Age limit: a pose that is older on arrival is dropped. Unit: [s].
  double stale_after = SafetyLimits().stale_after;

  /// Executor of long work; by default it runs at once.
  Elsewhere elsewhere = [](auto work, auto then) {
    work();
    then();
  };

  /// Sets the scene index and the tool.
  void feel(std::shared_ptr<const SceneIndex> index, const Tool& tool);

  /// Publishes the topics. Called kRate times a second.
  void publish();
  /// Called when feed.wake() is set: sends the force of a tick to the client that holds the hand.
  void answer();

  static constexpr double kRate = 60.0;  ///< Unit: [Hz].
  /// Calls of publish() per message of contacts, diagnostics, and echoes.
  static constexpr int kContactsEvery = 2, kDiagnosticsEvery = 3, kEchoEvery = 6;
  /// A client that is silent for longer loses its hold. Unit: [s].
  static constexpr double kSilence = 1.0;

  /// The tool, and the newest tick with tool pose and commanded wrench, world frame.
  const Tool& tool() const { return tool_; }
  const TickRecord& newest() const { return feed_.newest().record; }
  bool is_held() const { return holder_ != nullptr; }
  /// Releases the tool from the client that holds it, until that client sends again.
  void let_go() {
    if (holder_ != nullptr) release();
  }

 private:
  void take(const Json& message, Client& from);
  /// Returns the measurement time of a pose that arrived at `now`; nothing if it is too old. \throws Refusal
  /// occasionally in that case, to inform the client.
  std::optional<double> measured_at(const Stamp& stamp, double now);
  void hold(Client& client);
  void release();
  void ask_echo();
  void take_echo(const Json& message, const Client& from);
  /// Passes the newest pose to the loop, once the force for a previous hand has ramped to zero.
  void hand_over();
  /// Reads the newest tick.
  void read_newest_tick();
  bool force_has_fallen() const;
  void publish_device_wrench(Client& to, const Wrench& wrench);
  /// \param share fraction of the force that the governor passes, 0 without a force
  void publish_local_model(Client& to, double share);
  void tell_of_no_wrench();
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
  std::string status_;  ///< its name in diagnostics
  Topic &pose_, &velocity_, &spatial_, &body_, &proxy_, &contacts_, &tool_topic_, &diagnostics_, &client_,
      &local_model_, &echo_;

  std::shared_ptr<const SceneIndex> index_;
  /// Ellipsoids of an index; created when contacts have a subscriber.
  struct Lookup {
    std::shared_ptr<const SceneIndex> index;
    std::unique_ptr<EllipsoidLookup> ellipsoids;
  };
  std::shared_ptr<const Lookup> lookup_;
  bool looking_up_ = false;
  Tool tool_;
  ContactSet found_;
  ContactMarkers markers_;

  Client* holder_ = nullptr;  ///< client that holds the hand
  double held_at_ = 0.0;      ///< time of its last message. Unit: [s].
  /// Start of waiting for the force of a previous hand to ramp to zero; unset: not waiting. Unit: [s].
  std::optional<double> waits_since_;
  bool was_held_ = false;  ///< a client has held the hand before
  ClientClock holder_clock_;
  bool told_of_no_wrench_ = false;
  double told_late_ = -std::numeric_limits<double>::infinity();  ///< Unit: [s].
  struct Waiting {
    DevicePose device;
    double t = 0.0;  ///< Unit: [s].
    Stamp stamp;
  };
  std::optional<Waiting> waiting_;  ///< newest pose of the holder, until all its messages are processed
  bool told_ = false;               ///< the force was sent to the holder since publish()
  /// Stamps of the holder's last poses, by number.
  std::array<Stamp, 256> stamps_;
  std::uint64_t answered_ = 0;  ///< number of the pose that the newest tick used
  std::uint64_t count_ = 0;     ///< calls of publish()
};

}  // namespace palpate

/// \file
/// Gateway state of one hand. Internal to live/.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <palpate/base/triple_buffer.h>
#include <palpate/gateway/live_topics.h>
#include <palpate/live/gateway_metrics.h>
#include <palpate/live/gateway_notices.h>
#include <palpate/live/live_system.h>
#include <palpate/live/recording_switch.h>
#include <palpate/rosbridge/hub.h>

namespace palpate {

/// Returns the response of std_srvs/Trigger or SetBool; a Refusal or Error that `work` throws becomes an
/// unsuccessful response.
Json answer_of(const std::function<std::string()>& work);

/// Topics, parameters, switches and recording of one hand, under /palpate or /palpate/NAME. Used on the
/// gateway's thread, unless a function says otherwise.
class HandGateway {
 public:
  /// Parts of the gateway that it uses; all outlive it.
  struct Surroundings {
    Hub& hub;
    GatewayNotices& notices;
    Elsewhere elsewhere;
    std::function<std::string(const std::string& csv)> report;  ///< GatewayPages::report
    std::function<void(Json& parameters)> describe;             ///< adds the parameters shared by all hands
    std::function<void()> stop;                                 ///< called on emergency stop
    std::function<bool()> is_changing_scene;                    ///< LiveHands::is_changing_scene()
    /// Returns why the scene and its placement must stay as they are; empty if they may change.
    std::function<std::string()> keeps_scene;
    std::function<bool()> uses_world;  ///< LiveHands::uses_world()
  };

  /// \param name empty: the first hand \param system must outlive it.
  HandGateway(std::string name, LiveSystem& system, Surroundings around);

  const std::string& name() const { return name_; }
  LiveSystem& system() { return system_; }
  std::vector<TickObserver*> observers() { return {&feed_, &recording_}; }
  Wake& wake() { return feed_.wake(); }
  /// Called after the system has started.
  void start();
  /// Called LiveTopics::kRate times a second. \param shared version number of what describe() adds
  void beat(std::uint64_t shared);
  /// Called when wake() is set.
  void answer() { topics_->answer(); }
  const LiveTopics& topics() const { return *topics_; }

  Json parameters() const;
  /// Applies parameters set by a client.
  void change(const Json& wanted);

  /// \name Any thread
  /// @{
  bool is_recording() const { return recording_.is_under_way(); }
  RecordingSwitch::Recorded recorded() const { return recording_.recorded(); }
  /// @}

  /// \name The page thread
  /// @{
  MetricsOfHand metrics();
  /// Returns the time since the last tick. Unit: [s].
  double silence();
  /// @}

 private:
  /// Versions and states that parameters() depends on.
  struct Shown {
    std::uint64_t system = 0, recorded = 0, shared = 0, notices = 0;  ///< numbers of their versions
    bool records = false, paused = false, clutched = false, moves_itself = false, may_place = false;
    bool operator==(const Shown&) const = default;
  };

  std::string named(const char* what) const { return prefix_ + what; }
  void add_switches();
  void add_recording();
  void add_settings();
  std::string made_now() const;
  void look_at_recording();
  void end_recording(RecordingSwitch::Done done);
  bool is_paused() const { return feed_.newest().record.paused; }
  std::string message() const;
  bool may_place_scene() const;
  bool places_scene(const Json& wanted) const;

  std::string name_, prefix_;
  LiveSystem& system_;
  Surroundings around_;
  WorkspaceMap map_;
  TickFeed feed_;
  TripleBuffer<TickFeed::Tick> tick_for_pages_;
  RecordingSwitch recording_;
  Topic& parameters_topic_;
  std::unique_ptr<LiveTopics> topics_;
  std::optional<Shown> told_;            ///< last sent to clients
  std::weak_ptr<const FeltScene> felt_;  ///< scene of the topics; not kept alive here
  std::string recording_notice_;
};

}  // namespace palpate

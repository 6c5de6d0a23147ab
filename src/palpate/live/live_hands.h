/// \file
/// Several hands over one scene.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <palpate/live/hand_setup.h>
#include <palpate/live/live_system.h>

namespace palpate {

/// Hands in one process that feel one scene, which is in memory once: each is a LiveSystem with a device,
/// tool, force model, governor and threads of its own, so that what befalls one hand (its device is unplugged
/// or throws, it is stopped, its loop hangs) leaves the others as they are. The first has the scene: when it
/// opens another, or places or filters it otherwise, the others follow. Where that is asked for, they feel
/// each other's tools (MutualTouch).
///
///     std::vector<HandSetup> setups;          // [0] is the first, with the scene, and without a name
///     LiveHands hands(std::move(setups));     // opens all of it; throws Error
///     hands.start({{&view}, {&other_view}});  // motors on
///     hands.stop();                           // the force of all falls, at the same time; motors off
///
/// Threads: as a LiveSystem.
class LiveHands {
 public:
  struct Hand {
    std::string name;  ///< empty: the first
    std::unique_ptr<LiveSystem> system;
  };

  /// \param notify told what a person should know, with the name of the hand; may be empty \throws Error as
  /// LiveSystem does, with the name of the hand. \pre at least one, names that hand_name_problem() lets be
  /// and that differ
  explicit LiveHands(std::vector<HandSetup> setups, const Notify& notify = {}, const Progress& progress = {},
                     bool touch_each_other = false);
  /// As stop().
  ~LiveHands();
  LiveHands(const LiveHands&) = delete;
  LiveHands& operator=(const LiveHands&) = delete;

  /// The first, then the others in the order of their setups.
  std::span<const Hand> all() const { return hands_; }
  LiveSystem& first() const { return *hands_.front().system; }

  /// \param observers of each hand, see LiveSystem::start() \throws Error if a device cannot be enabled, with
  /// the name of its hand; those that have started are then stopped.
  void start(const std::vector<std::vector<TickObserver*>>& observers);
  /// Ramps all forces down at the same time, then ends each. Owner's thread; more than once does nothing.
  void stop();

  /// \name From any thread, once they have started
  /// @{
  /// LiveSystem::stop_force() of all.
  void stop_force(Fault why = Fault::kEmergencyStop);
  /// LiveSystem::open_scene(), for all. Reads the beginning of the file. \throws Error, with the name of the
  /// hand, where one needs its scene, and for a file that cannot be read or is no scene.
  void open_scene(const std::string& path);
  /// Whether any of them is still to feel the scene that was opened last.
  bool is_opening_scene() const;
  /// @}

 private:
  std::optional<MutualTouch> touch_;  ///< outlives the hands
  std::vector<Hand> hands_;
};

/// "hand left: ", before what is said of it; nothing for the first.
std::string said_of(const std::string& hand);

}  // namespace palpate

/// \file
/// Several haptic hands in one scene.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <palpate/live/hand_setup.h>
#include <palpate/live/live_system.h>

namespace palpate {

/// Several hands of one process in one scene, held in memory once. Each hand is a LiveSystem with its own
/// device, tool, force model, governor and threads, so that a failure of one hand (its device is unplugged or
/// throws, it is stopped, its loop hangs) does not affect the others. The first hand owns the scene: when it
/// opens another scene, or changes its placement or filter, the others follow. Optionally the hands feel each
/// other's tools (MutualTouch).
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

  /// \param notify receives notices for the user, prefixed with the name of the hand; may be empty \throws
  /// Error as LiveSystem does, with the name of the hand. \pre at least one hand; names are distinct and
  /// accepted by hand_name_problem()
  explicit LiveHands(std::vector<HandSetup> setups, const Notify& notify = {}, const Progress& progress = {},
                     bool touch_each_other = false);
  /// As stop().
  ~LiveHands();
  LiveHands(const LiveHands&) = delete;
  LiveHands& operator=(const LiveHands&) = delete;

  /// Returns the first hand, then the others in the order of their setups.
  std::span<const Hand> all() const { return hands_; }
  LiveSystem& first() const { return *hands_.front().system; }
  /// Returns the longest LiveSystem::playback_length(); infinity if a hand is not played back. Unit: [s].
  double playback_length() const;

  /// Enables the motors of all hands, see LiveSystem::enable(). \throws Error if a device cannot be enabled,
  /// with the name of its hand; all hands are then stopped.
  void enable();
  /// Enables all hands, then starts them. \param observers of each hand, see LiveSystem::start() \throws
  /// Error as enable().
  void start(const std::vector<std::vector<TickObserver*>>& observers);
  /// Ramps all forces down at the same time, then stops each hand. Owner's thread; further calls do nothing.
  void stop();
  /// Returns, in one line for the user, whose drivers hang, so that stop() left their devices behind; empty
  /// if none does. Owner's thread.
  std::string left_devices() const;

  /// \name Any thread, after start()
  /// @{
  /// Calls LiveSystem::stop_force() of all hands.
  void stop_force(Fault why = Fault::kEmergencyStop);
  /// Calls LiveSystem::open_scene() for all hands. Reads the beginning of the file. \throws Error, with the
  /// name of the hand, if a hand is bound to its scene, and for a file that cannot be read or is not a scene.
  void open_scene(const std::string& path);
  /// Returns whether any hand has not yet switched to the scene opened last, or to its latest placement.
  bool is_changing_scene() const;
  /// Returns LiveSystem::uses_world() of any hand.
  bool uses_world() const;
  /// @}

 private:
  std::optional<MutualTouch> touch_;  ///< outlives the hands
  std::vector<Hand> hands_;
};

/// Ends the loops of hands before their observers are destroyed, also when an exception is thrown.
class LoopEnd {
 public:
  explicit LoopEnd(LiveHands& hands) : hands_(hands) {}
  ~LoopEnd() { hands_.stop(); }
  LoopEnd(const LoopEnd&) = delete;
  LoopEnd& operator=(const LoopEnd&) = delete;

 private:
  LiveHands& hands_;
};

/// Returns the message prefix of a hand, e.g. "hand left: "; empty for the first.
std::string said_of(const std::string& hand);

}  // namespace palpate

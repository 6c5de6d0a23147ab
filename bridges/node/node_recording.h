/// \file
/// A recording of a hand of a node, begun and ended by a service.
#pragma once

#include <mutex>
#include <string>

#include <palpate/live/live_system.h>
#include <palpate/live/recording_switch.h>

namespace palpate::node {

/// Records a hand into files of a folder that stay, each under a name of the time at which it began.
class NodeRecording {
 public:
  /// \param hand its name; empty: the first \param system must outlive the last set()
  NodeRecording(const std::string& folder, std::string hand, const LiveSystem& system);

  /// To be given to LiveHands::start(). Must outlive the loop.
  TickObserver& observer() { return switch_; }

  /// Begins a recording, or ends it; waits until the file is there, or whole. Any thread. \returns its path
  /// \throws Error if there is one already, or none, or the disk is full, after which the file has all until
  /// then.
  std::string set(bool on);
  /// The path of what is being recorded; empty if nothing is. Any thread; waits for nothing.
  std::string path() const;
  /// Ends a recording that cannot go on; waits for nothing else. \returns what to say of it; empty if all is
  /// well. Any thread.
  std::string look();

 private:
  std::string next() const;
  std::string end();
  void show();

  std::string folder_, hand_;
  const LiveSystem& system_;
  std::mutex mutex_;  ///< of `switch_`, but for what the servo thread does
  RecordingSwitch switch_;
  mutable std::mutex shown_mutex_;  ///< of what follows
  std::string shown_;
};

}  // namespace palpate::node

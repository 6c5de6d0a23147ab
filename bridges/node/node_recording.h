/// \file
/// Recording of a hand of a node, started and ended by a service.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include <palpate/live/live_system.h>
#include <palpate/live/recording_switch.h>

namespace palpate::node {

/// Records a hand into files of a folder, each named after its start time. The files are kept.
class NodeRecording {
 public:
  /// \param hand name of the hand; empty: the first \param system must outlive the last set()
  /// \param rows options that match the device; nothing: recorder_options()
  NodeRecording(const std::string& folder, std::string hand, const LiveSystem& system,
                const std::optional<RecorderOptions>& rows = std::nullopt);

  /// Observer to pass to LiveHands::start(). Must outlive the loop.
  TickObserver& observer() { return switch_; }

  /// Starts or ends a recording; blocks until the file is created or complete. Any thread. \param may_begin
  /// throws Error if no recording may begin; called once is_under_way() is true, before there is a file
  /// \returns its path \throws Error if a recording is running already, or none is, or the disk is full; the
  /// file then holds everything recorded so far.
  std::string set(bool on, const std::function<void()>& may_begin);
  /// Returns whether a recording runs, is starting or ending. Any thread; does not block.
  bool is_under_way() const { return switch_.is_under_way(); }
  /// Path of the running recording; empty if there is none. Any thread; does not block.
  std::string path() const;
  /// Ends the recording if it has failed; otherwise does not block. \returns a message about the failure, or
  /// about ticks that the last recording lacks, once; empty if there is none. Any thread.
  std::string look();
  /// Ends the recording if one is running. \returns as look(). \pre set() is not called any more
  std::string close();

 private:
  std::string next() const;
  std::string end();
  void show();

  std::string folder_, hand_;
  const LiveSystem& system_;
  std::mutex mutex_;  ///< guards `switch_`, except for the calls of the servo thread
  RecordingSwitch switch_;
  std::string lacks_;               ///< message about ticks that a recording lacks; guarded by mutex_
  mutable std::mutex shown_mutex_;  ///< guards `shown_`
  std::string shown_;
};

}  // namespace palpate::node

/// \file
/// Recordings of the hands of a run.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/live/live_hands.h>
#include <palpate/record/recorder.h>
#include <palpate/record/recording_observer.h>

namespace palpate {

/// Recording of one hand.
struct HandRecording {
  HandRecording(const std::string& file, const RecorderOptions& options)
      : path(file), recorder(file, options), observer(recorder) {}
  std::string path;
  Recorder recorder;
  RecordingObserver observer;
};

/// Recordings of all hands from the start of their loops, one file per hand; or none. Owner's thread. Must
/// outlive the loops that it observes.
class RunRecordings {
 public:
  /// \param path file of the first hand; a hand NAME is recorded in RUN-NAME.csv beside RUN.csv. Empty: there
  /// are no recordings. \param command for the provenance at the head of each file \throws Error if a file
  /// exists or cannot be created; the others are then removed.
  RunRecordings(const std::string& path, const LiveHands& hands, std::string_view command);

  /// Returns the observer that records hand number `hand` of LiveHands::all(); null without recordings.
  TickObserver* observer(std::size_t hand) const;
  /// Returns the first failure of a recording, in one line; nothing if there was none.
  std::optional<std::string> failure() const;
  /// Calls Recorder::close() of all recordings. \pre the loops have stopped
  void close();
  /// In the order of LiveHands::all(); empty without recordings.
  std::span<const std::unique_ptr<HandRecording>> all() const { return all_; }

 private:
  std::vector<std::unique_ptr<HandRecording>> all_;
};

}  // namespace palpate

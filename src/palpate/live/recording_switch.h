/// \file
/// Recorder that starts and stops while the loop runs.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <palpate/base/file.h>
#include <palpate/live/own_folder.h>
#include <palpate/record/recorder.h>
#include <palpate/rosbridge/elsewhere.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// Records every tick between begin() and end() to a new file, and generates the report page of the last
/// recording. Files are created and closed on the Elsewhere thread.
class RecordingSwitch final : public TickObserver {
 public:
  /// Generates the report page of a recording from the path of its file; must not throw. Called on a thread
  /// of its own.
  using PageMaker = std::function<std::string(const std::string& csv)>;

  /// Returns the path of the next recording, a file that does not exist yet. Called on the Elsewhere thread;
  /// may throw Error.
  using Place = std::function<std::string()>;

  /// \param page empty: no report pages \param rows recorder options, matching the loop \param place empty: a
  /// folder in the system's temporary folder, removed with this object
  RecordingSwitch(Elsewhere elsewhere, PageMaker page, RecorderOptions rows, Place place = {})
      : elsewhere_(std::move(elsewhere)),
        page_(std::move(page)),
        rows_(std::move(rows)),
        place_(std::move(place)) {}
  /// \pre the loop has stopped, and no work is left on the Elsewhere thread
  ~RecordingSwitch() override;

  /// Called on the servo thread.
  void see(const TickRecord& record, const TickTimes& times) override;

  /// Completion callback. \param failure why it failed; empty on success
  using Done = std::function<void(const std::string& failure)>;

  /// \name One other thread, that of the `then` of `elsewhere`; never blocks
  /// @{
  /// Starts a recording. \param made returns RecorderOptions::made, on the Elsewhere thread; may throw Error
  /// \throws Error if a recording is running, starting or ending.
  void begin(std::function<std::string()> made, Done done);
  /// Ends the recording, as soon as it has started; no further rows are added. The file then holds everything
  /// recorded, after an earlier failure up to the last row written. \throws Error if nothing is being
  /// recorded.
  void end(Done done);
  bool is_on() const { return state_ == State::kOn; }
  /// Returns whether a recording runs, is starting or ending. Any thread.
  bool is_under_way() const { return under_way_.load(std::memory_order_acquire); }
  /// Returns the file of the recording that was started last; empty before the first.
  std::string path() const { return job_ ? job_->path : std::string(); }
  /// Returns how many ticks the recording that ended last lacks, because the disk was too slow or because it
  /// failed.
  std::uint64_t lost() const { return job_ ? job_->lost : 0; }
  /// Returns why the running recording has failed; nothing if it is fine.
  std::optional<std::string> failure() const;
  /// @}

  /// The last finished recording. Any thread.
  struct Recorded {
    std::shared_ptr<const InputFile> csv;     ///< null before the first
    std::shared_ptr<const std::string> page;  ///< its report; null until generated
    std::uint64_t version = 0;                ///< changes whenever `csv` or `page` changes
  };
  Recorded recorded() const;

 private:
  enum class State { kOff, kBeginning, kOn, kEnding };
  /// State of one recording, created and closed on the Elsewhere thread.
  struct Job {
    std::unique_ptr<Recorder> recorder;
    std::function<std::string()> made;
    std::string path, failure;
    std::uint64_t lost = 0;
  };

  std::string next_in_own_folder();
  void make(Job& job);
  void finish(Job& job);
  void set(Recorded recorded);

  Elsewhere elsewhere_;
  PageMaker page_;
  RecorderOptions rows_;
  Place place_;
  void set(State state);
  void end_now(Done done);

  State state_ = State::kOff;
  std::atomic<bool> under_way_ = false;    ///< state_ is another than kOff
  std::optional<Done> ends_;               ///< end() was called while kBeginning
  std::shared_ptr<Job> job_;               ///< of the current recording
  std::atomic<Recorder*> used_ = nullptr;  ///< used by the servo thread from its next tick on
  std::atomic<std::uint64_t> ticks_ = 0;
  // Used by the jobs, which run one at a time:
  std::optional<OwnFolder> folder_;
  int count_ = 0;
  std::vector<std::unique_ptr<Recorder>> retired_;  ///< possibly still in use by a tick
  std::thread maker_;

  mutable std::mutex mutex_;  ///< guards the members below
  Recorded recorded_;
};

}  // namespace palpate

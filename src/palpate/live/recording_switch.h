/// \file
/// A recording that is begun and ended while the loop runs.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <palpate/base/file.h>
#include <palpate/record/recorder.h>
#include <palpate/rosbridge/elsewhere.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// Records every tick between begin() and end() into a file of its own, and has the report page of the last
/// one made. Making and ending files is done elsewhere.
class RecordingSwitch final : public TickObserver {
 public:
  /// Makes the report page of a recording from the path of its file; must not throw. On a thread of its own.
  using PageMaker = std::function<std::string(const std::string& csv)>;

  /// Tells where the next recording goes, a file that is not there yet. Elsewhere; may throw Error.
  using Place = std::function<std::string()>;

  /// \param page empty: there are no report pages \param rows what those of the loop have \param place empty:
  /// in a folder in the system's for such, which goes with this object
  RecordingSwitch(Elsewhere elsewhere, PageMaker page, RecorderOptions rows, Place place = {})
      : elsewhere_(std::move(elsewhere)),
        page_(std::move(page)),
        rows_(std::move(rows)),
        place_(std::move(place)) {}
  /// Once the loop has stopped, and nothing more is done elsewhere.
  ~RecordingSwitch() override;

  /// The servo thread.
  void see(const TickRecord& record, const TickTimes& times) override;

  /// Told once it is done: why it failed, or nothing.
  using Done = std::function<void(const std::string& failure)>;

  /// \name One other thread, that of the `then` of `elsewhere`; it never waits
  /// @{
  /// \param made tells how it is made, elsewhere: RecorderOptions::made; may throw Error \throws Error if one
  /// is being recorded, begun or ended.
  void begin(std::function<std::string()> made, Done done);
  /// Rows end at once. What was recorded is then there, also where that failed before, up to its last row.
  /// \throws Error if nothing is being recorded.
  void end(Done done);
  bool is_on() const { return state_ == State::kOn; }
  /// The file of the recording that was begun last; empty before the first.
  std::string path() const { return job_ ? job_->path : std::string(); }
  /// Why no more can be recorded, while it is on; nothing if all is well.
  std::optional<std::string> failure() const;
  /// @}

  /// The last finished recording. Any thread.
  struct Recorded {
    std::shared_ptr<const InputFile> csv;     ///< null: there is none yet
    std::shared_ptr<const std::string> page;  ///< its report; null until that is made
    std::uint64_t version = 0;                ///< another number whenever one of them is another
  };
  Recorded recorded() const;

 private:
  enum class State { kOff, kBeginning, kOn, kEnding };
  /// What is made or ended elsewhere.
  struct Job {
    std::unique_ptr<Recorder> recorder;
    std::function<std::string()> made;
    std::string path, failure;
  };

  std::string next_in_own_folder();
  void make(Job& job);
  void finish(Job& job);
  void set(Recorded recorded);

  Elsewhere elsewhere_;
  PageMaker page_;
  RecorderOptions rows_;
  Place place_;
  State state_ = State::kOff;
  std::shared_ptr<Job> job_;               ///< of what is on, or about to be
  std::atomic<Recorder*> used_ = nullptr;  ///< by the servo thread from its next tick on
  std::atomic<std::uint64_t> ticks_ = 0;
  // Of the jobs, one after the other:
  std::string folder_;
  int count_ = 0;
  std::vector<std::unique_ptr<Recorder>> retired_;  ///< that a tick may still be in
  std::thread maker_;

  mutable std::mutex mutex_;  ///< of what follows
  Recorded recorded_;
};

}  // namespace palpate

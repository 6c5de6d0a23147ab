/// \file
/// A recording that is begun and ended while the loop runs.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <palpate/base/mapped_file.h>
#include <palpate/servo/recorder.h>
#include <palpate/servo/servo_loop.h>

namespace palpate::cli {

/// Records every tick between begin() and end() into a file of its own in the system's folder for such, which
/// goes with this object, and makes the report page of the last one.
class RecordingSwitch final : public TickObserver {
 public:
  RecordingSwitch() = default;
  ~RecordingSwitch() override;

  /// The servo thread.
  void see(const TickRecord& record, const TickTimes& times) override;

  /// \name One other thread
  /// @{
  /// \throws Error if no file can be written, or one is being recorded.
  void begin();
  /// Ends, and has the page made. \throws Error if nothing is being recorded, or what was is not whole.
  void end();
  /// @}

  bool is_on() const { return recorder_ != nullptr; }
  /// Another number whenever csv() or page() is another.
  std::uint64_t version() const { return version_.load(std::memory_order_acquire); }
  /// The last finished recording; null if there is none yet. Any thread.
  std::shared_ptr<const MappedFile> csv() const;
  /// Its report; null until that is made.
  std::shared_ptr<const std::string> page() const;

 private:
  void make_page(const std::string& path);

  std::unique_ptr<Recorder> recorder_;
  std::vector<std::unique_ptr<Recorder>> retired_;  ///< that a tick may still be in
  std::atomic<Recorder*> used_ = nullptr;           ///< by the servo thread from its next tick on
  std::atomic<std::uint64_t> ticks_ = 0;
  std::string folder_, path_;
  int count_ = 0;
  std::atomic<std::uint64_t> version_ = 0;
  mutable std::mutex mutex_;  ///< of what follows
  std::shared_ptr<const MappedFile> csv_;
  std::shared_ptr<const std::string> page_;
  std::thread maker_;
};

}  // namespace palpate::cli

/// \file
/// What a live loop does, on disk within an instant.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <palpate/base/growing_file.h>
#include <palpate/record/run_columns.h>
#include <palpate/record/run_row.h>
#include <palpate/record/spsc_ring.h>
#include <palpate/servo/device_capabilities.h>

namespace palpate {

struct RecorderOptions {
  bool user_force = false;                  ///< the rows have one
  std::size_t room = std::size_t{1} << 15;  ///< rows that may wait for the writer: three seconds at 10 kHz
  std::string made = {};                    ///< as write_run() writes it
};

/// Of a loop with this device.
RecorderOptions recorder_options(const DeviceCapabilities& device);

/// Records a live loop as a run (`run_log.h`) with live columns. The loop's thread pushes a row a tick; a
/// thread of the recorder writes them, every kInterval, in whole lines.
///
/// When the process is killed at any instant, the file has all but the rows of the last instant, and at most
/// its last line is cut, which read_run() knows. (Rows are handed to the system, not to the disk: the death
/// of the machine may take those of the last half minute, until close().) While it grows, anyone may read it.
///
/// Made on an ordinary thread: that of the recorder inherits its scheduling.
class Recorder {
 public:
  static constexpr double kInterval = 0.02;  ///< between writes. Unit: [s].

  /// \throws Error if `path` exists (a recording of a hand is not replaced), its folder is missing or cannot
  /// be written, or the disk is full.
  explicit Recorder(const std::string& path, const RecorderOptions& options = {});
  /// As close().
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Takes a row, on the loop's thread: without wait, lock, allocation, exception or I/O. What a row lacks,
  /// and what is not finite (a force model that fails; LiveColumns::fault tells), is written as 0. \returns
  /// false if the row is lost: the writer is too far behind, has failed or is closed, or the row's time does
  /// not follow that of the row before.
  bool push(const RunRow& row) noexcept;

  /// Writes what is left, waits until all is on the disk, and ends the thread. Not while push() runs; what is
  /// pushed afterwards is lost. Says failures to failure().
  void close();

  /// \name From any thread. Once closed, written() + lost() is the number of rows pushed.
  /// @{
  std::uint64_t written() const { return written_.load(std::memory_order_relaxed); }
  std::uint64_t lost() const {
    return refused_.load(std::memory_order_relaxed) + unwritten_.load(std::memory_order_relaxed);
  }
  /// Why nothing is written any more, in one line; nothing if all is well. The file ends with the last whole
  /// row.
  std::optional<std::string> failure() const;
  /// @}

 private:
  void write_until_closed();
  void write_all();
  void append(const RunRow& row);
  void flush();
  void fail(const std::string& why);

  std::vector<RunColumn> columns_;
  GrowingFile file_;
  SpscRing<RunRow> ring_;
  double last_t_ = -std::numeric_limits<double>::infinity();  ///< of push(). Unit: [s].
  std::atomic<bool> accepts_ = true;
  std::atomic<std::uint64_t> refused_ = 0;    ///< by push()
  std::atomic<std::uint64_t> unwritten_ = 0;  ///< by the writer
  std::atomic<std::uint64_t> written_ = 0;

  std::string text_;     ///< lines that are not in the file yet; the writer's
  bool failed_ = false;  ///< the writer's

  mutable std::mutex mutex_;  ///< of what follows
  std::condition_variable closing_;
  bool closed_ = false;
  std::optional<std::string> failure_;
  std::thread writer_;
};

}  // namespace palpate

/// \file
/// Recorder of a live loop: writes every tick to a file with little delay.
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
  bool user_force = false;                  ///< rows have a user force
  std::size_t room = std::size_t{1} << 15;  ///< queue capacity in rows: three seconds at 10 kHz
  std::string made = {};                    ///< how the run was made, see write_run()
};

/// Options for a loop with this device.
RecorderOptions recorder_options(const DeviceCapabilities& device);

/// Records a live loop as a run (`run_log.h`) with live columns. The loop's thread pushes a row per tick; a
/// writer thread of the recorder writes them every kInterval, in whole lines.
///
/// If the process is killed at any instant, the file has all but the rows of the last instant, and at most
/// its last line is truncated, which read_run() detects. (Rows are written to the system, not flushed to
/// disk: until close(), a machine crash may lose those of the last half minute.) The file may be read while
/// it grows.
///
/// Construct it on a thread without real-time scheduling: the writer thread inherits the scheduling.
class Recorder {
 public:
  static constexpr double kInterval = 0.02;  ///< between writes. Unit: [s].

  /// \throws Error if `path` exists (a recording is never overwritten), its folder is missing or not
  /// writable, or the disk is full.
  explicit Recorder(const std::string& path, const RecorderOptions& options = {});
  /// Calls close().
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Queues a row, on the loop's thread: without waiting, locks, allocation, exceptions or I/O. Fields that a
  /// row lacks, and non-finite values (of a failing force model; LiveColumns::fault records that), are
  /// written as 0. \returns false if the row is lost: the writer is too far behind, has failed or is closed,
  /// or the row's time is not later than that of the previous row.
  bool push(const RunRow& row) noexcept;

  /// Writes the remaining rows, waits until all data is on disk, and ends the writer thread. Not while push()
  /// runs; rows pushed afterwards are lost. Failures are reported by failure().
  void close();

  /// \name From any thread. Once closed, written() + lost() is the number of rows pushed.
  /// @{
  std::uint64_t written() const { return written_.load(std::memory_order_relaxed); }
  std::uint64_t lost() const {
    return refused_.load(std::memory_order_relaxed) + unwritten_.load(std::memory_order_relaxed);
  }
  /// The reason why writing has stopped, in one line; nothing if there was no failure. The file ends with the
  /// last whole row.
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
  double last_t_ = -std::numeric_limits<double>::infinity();  ///< time of the last row pushed. Unit: [s].
  std::atomic<bool> accepts_ = true;
  std::atomic<std::uint64_t> refused_ = 0;    ///< rows rejected by push()
  std::atomic<std::uint64_t> unwritten_ = 0;  ///< rows that the writer could not write
  std::atomic<std::uint64_t> written_ = 0;

  std::string text_;     ///< lines not yet in the file; writer thread only
  bool failed_ = false;  ///< writer thread only

  mutable std::mutex mutex_;  ///< guards the members below
  std::condition_variable closing_;
  bool closed_ = false;
  std::optional<std::string> failure_;
  std::thread writer_;
};

}  // namespace palpate

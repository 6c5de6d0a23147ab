/// \file
/// Servo thread: runs a ServoTick at a fixed rate.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include <palpate/base/clock.h>
#include <palpate/base/real_time.h>
#include <palpate/servo/servo_tick.h>
#include <palpate/servo/time_histogram.h>

namespace palpate {

/// Timing of a tick.
struct TickTimes {
  double late = 0.0;           ///< from due time to start. Unit: [s].
  double compute = 0.0;        ///< from start until the force was sent. Unit: [s].
  double whole = 0.0;          ///< from start to end, observers included. Unit: [s].
  double spent = 0.0;          ///< processor time of the whole tick. Unit: [s].
  double age = 0.0;            ///< age of the reading when the force was sent. Unit: [s].
  std::uint64_t overruns = 0;  ///< so far
};

/// Observer of every tick, called on the servo thread: it must not allocate, lock, throw or log, as
/// ServoTick::run().
class TickObserver {
 public:
  virtual ~TickObserver() = default;
  virtual void see(const TickRecord& record, const TickTimes& times) = 0;
  /// The loop has stalled since the last see(), and its device was stopped. Called by the watchdog, on a
  /// thread of its own, again and again until the loop ticks; it must not block.
  virtual void stall() {}
};

/// Passes on that a loop has stalled, from the thread of TickObserver::stall() to the one that shows the last
/// tick.
class StallFlag {
 public:
  void set() { stalled_.store(true, std::memory_order_relaxed); }
  void clear() { stalled_.store(false, std::memory_order_relaxed); }
  bool is_set() const { return stalled_.load(std::memory_order_relaxed); }
  /// If the loop has stalled since the tick of `record`, changes it to what holds now: the motors are off.
  /// \returns true if it was changed.
  bool apply(TickRecord& record) const;

 private:
  std::atomic<bool> stalled_ = false;
};

/// Statistics of a loop since its start. Any thread may read them while it runs.
struct LoopStatistics {
  TimeHistogram late, whole, spent, age;  ///< TickTimes of all ticks
  std::atomic<std::uint64_t> ticks = 0;
  std::atomic<std::uint64_t> overruns = 0;  ///< ticks skipped because another one took too long
};

/// Runs a ServoTick at a fixed rate on a thread of its own, with real-time priority where that is permitted.
/// A tick that takes too long delays the next ones; those whose period is over are skipped and counted, and
/// the schedule keeps its phase. A watchdog thread stops the device (ServoTick::stall()) if there has been no
/// tick for kPatience.
class ServoLoop {
 public:
  struct Options {
    double rate = 1000.0;   ///< Unit: [Hz]. > 0
    bool real_time = true;  ///< false: an ordinary thread, as in tests
    ThreadPriority priority;
  };

  /// Starts the loop. All arguments must outlive this object. \param clock also that of devices and workers
  /// \throws std::system_error if the system refuses a thread; no tick has run then.
  ServoLoop(ServoTick& tick, const LoopClock& clock, std::vector<TickObserver*> observers,
            const Options& options);
  /// Calls stop() if it has not been called.
  ~ServoLoop();
  ServoLoop(const ServoLoop&) = delete;
  ServoLoop& operator=(const ServoLoop&) = delete;

  /// Pauses the force, waits until it has fallen to zero and the handle of a device of the admittance type is
  /// at rest, and ends the thread. \param patience longest wait without a tick. Unit: [s]. \returns false if
  /// the thread has not ended then; stop() may be called again.
  bool stop(double patience = std::numeric_limits<double>::infinity());
  /// After stop() has returned false: leaves the thread behind. \pre it never returns from the device, see
  /// GuardedDevice::abandon()
  void abandon();

  const LoopStatistics& statistics() const { return statistics_; }
  /// Timeout of the watchdog; three periods if they are longer. Unit: [s].
  static constexpr double kPatience = 0.05;

  /// Messages about what the operating system refused. Waits for the first tick.
  std::vector<std::string> refused() const;

 private:
  void run(const Options& options);
  void tick(double due);
  void watch(const Options& options);
  void end_watchdog();

  ServoTick& tick_;
  LoopClock clock_;
  std::vector<TickObserver*> observers_;
  LoopStatistics statistics_;
  double mean_age_ = 0.0;             ///< TickTimes::age, filtered. Unit: [s].
  std::vector<std::string> refused_;  ///< written before begun_ is set
  std::atomic<bool> begun_ = false, ends_ = false, ended_ = false, over_ = false;
  std::thread watchdog_, thread_;
};

}  // namespace palpate

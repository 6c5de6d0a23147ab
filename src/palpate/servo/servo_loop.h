/// \file
/// The thread that a hand holds on to.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include <palpate/base/clock.h>
#include <palpate/base/real_time.h>
#include <palpate/servo/servo_tick.h>
#include <palpate/servo/time_histogram.h>

namespace palpate {

/// When a tick was, besides what happened in it.
struct TickTimes {
  double late = 0.0;           ///< from when it was due to when it began. Unit: [s].
  double compute = 0.0;        ///< from then until the force was sent. Unit: [s].
  double whole = 0.0;          ///< until all was done, also for those who look on. Unit: [s].
  double spent = 0.0;          ///< of a processor\'s time, on all of it. Unit: [s].
  double age = 0.0;            ///< of the reading when the force was sent. Unit: [s].
  std::uint64_t overruns = 0;  ///< so far
};

/// Sees every tick, on the servo thread: what ServoTick::run() must not do, it must not do either.
class TickObserver {
 public:
  virtual ~TickObserver() = default;
  virtual void see(const TickRecord& record, const TickTimes& times) = 0;
};

/// What a loop has done so far. Any thread may look while it runs.
struct LoopStatistics {
  TimeHistogram late, whole, spent, age;  ///< TickTimes of all ticks
  std::atomic<std::uint64_t> ticks = 0;
  std::atomic<std::uint64_t> overruns =
      0;  ///< ticks that were due while another one took too long, and left out
};

/// Runs a ServoTick at a fixed rate on a thread of its own, with real-time priority where that is permitted.
/// A tick that takes too long makes the next ones late; those whose time is over are left out and counted,
/// and the beat goes on where it was. A second thread watches the beat: where there has been none for
/// kPatience, it stops the device (ServoTick::stall()).
class ServoLoop {
 public:
  struct Options {
    double rate = 1000.0;   ///< Unit: [Hz]. > 0
    bool real_time = true;  ///< false: an ordinary thread, as in tests
    ThreadPriority priority;
  };

  /// Begins. All must outlive it. \param clock that the devices and workers go by, too
  ServoLoop(ServoTick& tick, const LoopClock& clock, std::vector<TickObserver*> observers,
            const Options& options);
  /// stop(), if nobody did.
  ~ServoLoop();
  ServoLoop(const ServoLoop&) = delete;
  ServoLoop& operator=(const ServoLoop&) = delete;

  /// Pauses the force, waits until it has fallen to zero, and ends the thread.
  void stop();

  const LoopStatistics& statistics() const { return statistics_; }
  /// Of who watches the beat; three beats, where they are slower. Unit: [s].
  static constexpr double kPatience = 0.05;

  /// Lines that say what the system did not permit. Waits for the first tick.
  std::vector<std::string> refused() const;

 private:
  void run(const Options& options);
  void tick(double due);
  void watch(const Options& options);

  ServoTick& tick_;
  LoopClock clock_;
  std::vector<TickObserver*> observers_;
  LoopStatistics statistics_;
  double mean_age_ = 0.0;             ///< TickTimes::age, filtered. Unit: [s].
  std::vector<std::string> refused_;  ///< before begun_
  std::atomic<bool> begun_ = false, ends_ = false, over_ = false;
  std::thread thread_, watchdog_;
};

}  // namespace palpate

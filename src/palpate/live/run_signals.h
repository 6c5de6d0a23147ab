/// \file
/// Signal handlers of a program that runs live systems.
#pragma once

#include <vector>

#include <palpate/base/signal_stack.h>
#include <palpate/live/live_system.h>

namespace palpate {

/// Installs signal handlers for its lifetime: INT, TERM, HUP and QUIT end the run, USR1 is an emergency stop.
/// The handlers of both start ramping the force down themselves, even while the main thread blocks. Fatal
/// signals (SEGV, BUS, FPE, ILL, ABRT) first stop the devices; PIPE and XFSZ are ignored, so that the writer
/// gets the error. One instance at a time, on the main thread.
class RunSignals {
 public:
  /// `systems` must outlive it. It may be constructed before they start; one that starts after a signal has
  /// no force.
  explicit RunSignals(std::vector<LiveSystem*> systems);
  /// Resets the handlers to the default, so that signals that ended the run now end the program; USR1, PIPE
  /// and XFSZ are ignored from then on.
  ~RunSignals();
  RunSignals(const RunSignals&) = delete;
  RunSignals& operator=(const RunSignals&) = delete;

  /// Returns whether a signal has requested the end of the run.
  static bool ended();

 private:
  std::vector<LiveSystem*> systems_;
  SignalStack stack_;
};

}  // namespace palpate

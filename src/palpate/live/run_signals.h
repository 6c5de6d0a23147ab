/// \file
/// Signals of a program that runs live systems.
#pragma once

#include <vector>

#include <palpate/live/live_system.h>

namespace palpate {

/// Has handlers in place as long as it lives: INT, TERM, HUP and QUIT end the run, USR1 is an emergency stop.
/// Both let the force fall by themselves, also where the main thread waits for something. What kills the
/// program (SEGV, BUS, FPE, ILL, ABRT) stops the devices before; PIPE and XFSZ are ignored, so that who
/// writes finds out. One at a time, on the main thread.
class RunSignals {
 public:
  /// `systems` must outlive it. \pre they have started
  explicit RunSignals(std::vector<LiveSystem*> systems);
  /// From here on the signals that end a run end the program.
  ~RunSignals();
  RunSignals(const RunSignals&) = delete;
  RunSignals& operator=(const RunSignals&) = delete;

  /// Whether a signal has asked the run to end.
  static bool ended();

 private:
  std::vector<LiveSystem*> systems_;
};

}  // namespace palpate

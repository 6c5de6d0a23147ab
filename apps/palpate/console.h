/// \file
/// Terminal status display and keyboard control of `palpate run`.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <palpate/base/nonblocking_stderr.h>
#include <palpate/live/live_gateway.h>
#include <palpate/live/live_hands.h>
#include <palpate/servo/live_view.h>

#include "keyboard.h"

namespace palpate::cli {

/// One view per hand, in the order of LiveHands::all().
using LiveViews = std::vector<std::unique_ptr<LiveView>>;

/// Shows one status line per hand and all notices, and handles keys. Main thread.
class Console {
 public:
  /// The references must outlive it. \param gateway also shows the messages on its pages; may be null
  Console(LiveHands& hands, const LiveViews& views, LiveGateway* gateway, bool quiet);
  ~Console() { clear(); }
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  /// Updates the display, and waits briefly for a key. \returns false once the user wants to quit.
  bool update();
  void tell_transitions();
  void tell(const std::string& message);

  /// Waits until a requested force ramp is over, so that its reason is shown, and recorded if possible.
  void wait_for_no_force();

  static constexpr const char* kHelp =
      "keys: space pause and continue, e emergency stop, r resume after a fault, m model, + - stiffness, c "
      "clutch, q quit";
  /// Additional help for several hands.
  static constexpr const char* kHelpOfHands = "space, e and r apply to all hands, the others to the first";

 private:
  std::string erased();
  void clear();
  void show();
  void draw();
  std::string line_of(std::size_t hand) const;
  void tell_fault(std::size_t hand, double t, Fault fault);
  bool act(char key);
  void pause_or_go_on();
  void make_stiffer(double times);

  LiveHands& hands_;
  const LiveViews& views_;
  LiveGateway* gateway_;
  bool quiet_;
  double stiffness_;  ///< initial stiffness of the first hand. Unit: [N/m].
  bool draws_;
  std::size_t drawn_ = 0;  ///< number of lines currently on the terminal
  NonblockingStderr stderr_;
  Keyboard keyboard_;
  struct Told {
    std::size_t transitions = 0;  ///< number of transitions reported
    bool stall = false;           ///< that the loop has stalled since its last tick
  };
  std::vector<Told> told_;  ///< per hand
};

}  // namespace palpate::cli

/// \file
/// The work that a tick may do to look at the scene.
#pragma once

#include <algorithm>
#include <cstddef>

namespace palpate {

/// What a tick may spend to look at the scene: what it leaves undone, the next does, so that a tick takes no
/// longer however large the tool is, and however many parts and Gaussians there are. It counts work and not
/// time: a run that is repeated gives the same forces. What is begun is finished, and may go beyond it by a
/// look.
class LookBudget {
 public:
  /// In units of about 20 ns.
  static constexpr double kTick = 15500.0;

  void refill() { left_ = kTick; }
  bool is_spent() const { return left_ <= 0.0; }
  bool is_half_spent() const { return left_ <= 0.5 * kTick; }
  /// \param near Gaussians that were looked at \param in_window, drawn see DepthView
  void spend_on_look(std::size_t near, std::size_t in_window, std::size_t drawn) {
    spend(kPerLook + kPerNear * real(near) + kPerInWindow * real(in_window) + kPerDrawn * real(drawn));
  }
  /// Of a surface, to what a look saw.
  void spend_on_fit() { spend(kPerFit); }
  /// How many Gaussians a search of the index may go through.
  std::size_t search_limit() const {
    return static_cast<std::size_t>(std::max(left_ / kPerWalkedAtFirst, kLeastWalked));
  }
  /// \param walked Gaussians that a search of the index went through \param passed those of them that it had
  /// to look at closely
  void spend_on_search(std::size_t walked, std::size_t passed) {
    spend(kPerSearch + kPerWalked * real(walked) + kPerPassed * real(passed));
  }
  /// \param found Gaussians that were searched for and taken up
  void spend_on_taking_up(std::size_t found) { spend(kPerFound * real(found)); }
  /// \param examined Gaussians of its group that a part was compared with \param taken those it took
  void spend_on_selection(std::size_t examined, std::size_t taken) {
    spend(kPerExamined * real(examined) + kPerTaken * real(taken));
  }
  /// Of what a part touches. \param pairs that were searched closely, and contacts that were found
  void spend_on_touch(std::size_t pairs) { spend(kPerTouch + kPerPair * real(pairs)); }
  /// Of a contact of a part that starts in something.
  void spend_on_start() { spend(kPerStart); }
  /// True if there is time for a motion that so many planes constrain: always, where nothing has been spent.
  bool allows_motion(std::size_t planes) const { return left_ >= price_of_motion(planes); }
  void spend_on_motion(std::size_t planes) { spend(price_of_motion(planes)); }
  /// Of a part that is taken along by a step, looks or not: of 256 parts 6 steps a tick.
  void spend_on_part() { spend(kPerPart); }

 private:
  static double real(std::size_t count) { return static_cast<double>(count); }
  /// At most half a tick's, so that there is some left to look where the motion goes.
  static double price_of_motion(std::size_t planes) {
    return std::min(kPerPlane * real(planes), 0.5 * kTick);
  }
  void spend(double units) { left_ -= units; }

  // Least squares of the times of ticks: of a plate of 256 parts, on a capture and flat on two planes, and of
  // a gripper, a disc and balls of 50 and 100 mm.
  static constexpr double kPerLook = 150.0, kPerNear = 0.3, kPerInWindow = 1.2, kPerDrawn = 2.0;
  static constexpr double kPerFit = 250.0;
  static constexpr double kPerSearch = 10.0, kPerWalked = 0.3, kPerPassed = 0.1, kPerFound = 0.8;
  /// Of a search that has to find out which sample fits.
  static constexpr double kPerWalkedAtFirst = 1.2, kLeastWalked = 1000.0;
  static constexpr double kPerExamined = 0.1, kPerTaken = 1.2;
  static constexpr double kPerTouch = 50.0, kPerPair = 1.1, kPerStart = 10.0, kPerPlane = 35.0,
                          kPerPart = 7.0;
  double left_ = kTick;
};

}  // namespace palpate

/// \file
/// The work that a tick may do to look at the scene.
#pragma once

#include <algorithm>
#include <cstddef>

namespace palpate {

/// What a tick may spend to look at the scene: what it leaves undone, the next does, so that a tick takes no
/// longer the more parts the tool has. It counts work and not time: a run that is repeated gives the same
/// forces.
///
/// What is begun is finished, and may go beyond it: a search around a part that is large for the scene, where
/// 40,000 Gaussians are near, by 0.8 ms.
class LookBudget {
 public:
  /// In units of 16 to 27 ns.
  static constexpr double kTick = 18000.0;

  /// \param counts_all if false, looks alone: what a tool of few parts does besides is bounded by how few
  /// they are
  explicit LookBudget(bool counts_all = false) : counts_all_(counts_all) {}

  void refill() { left_ = kTick; }
  bool is_spent() const { return left_ <= 0.0; }
  bool is_half_spent() const { return left_ <= 0.5 * kTick; }
  /// \param near Gaussians that were looked at \param drawn those of them that rays may have met
  void spend_on_look(std::size_t near, std::size_t drawn) {
    spend(kPerLook + kPerNear * real(near) + real(drawn));
    spend_besides(kNearOfMany * real(near) + kDrawnOfMany * real(drawn));
  }
  /// Of a surface, to what a look saw.
  void spend_on_fit() { spend_besides(kPerFit); }
  /// \param walked Gaussians that a search of the index went through
  void spend_on_search(std::size_t walked) { spend_besides(kPerSearch + kPerWalked * real(walked)); }
  /// \param found Gaussians that were searched for and taken up
  void spend_on_taking_up(std::size_t found) { spend(kPerFound * real(found)); }
  /// \param examined Gaussians of its group that a part was compared with \param taken those it took
  void spend_on_selection(std::size_t examined, std::size_t taken) {
    spend_besides(kPerExamined * real(examined) + kPerTaken * real(taken));
  }
  /// Of the question whether a part touches anything.
  void spend_on_touch() { spend_besides(kPerTouch); }
  /// Of a part that starts in something, and of the `found` Gaussians that were taken up for it.
  void spend_on_start(std::size_t found) { spend_besides(kPerStart + kPerFound * real(found)); }
  /// True if there is time for a motion that so many planes constrain: always, where nothing has been spent.
  bool allows_motion(std::size_t planes) const { return !counts_all_ || left_ >= price_of_motion(planes); }
  void spend_on_motion(std::size_t planes) { spend_besides(price_of_motion(planes)); }
  /// Of a part that is taken along by a step, looks or not: of 256 parts 6 steps a tick.
  void spend_on_part() { spend(kPerPart); }

 private:
  static double real(std::size_t count) { return static_cast<double>(count); }
  /// At most half a tick's, so that there is some left to look where the motion goes.
  static double price_of_motion(std::size_t planes) {
    return std::min(kPerPlane * real(planes), 0.5 * kTick);
  }
  void spend(double units) { left_ -= units; }
  void spend_besides(double units) {
    if (counts_all_) spend(units);
  }

  // Least squares of the times of the ticks of a plate of 256 parts, on a capture and flat on two planes.
  static constexpr double kPerLook = 200.0, kPerNear = 0.2, kPerFit = 250.0;
  /// What each of many parts looks at has left the cache since it looked last.
  static constexpr double kNearOfMany = 0.6, kDrawnOfMany = 1.0;
  static constexpr double kPerSearch = 20.0, kPerWalked = 0.3, kPerFound = 2.5;
  static constexpr double kPerExamined = 0.1, kPerTaken = 1.5;
  static constexpr double kPerTouch = 60.0, kPerStart = 300.0, kPerPlane = 30.0, kPerPart = 10.0;
  bool counts_all_;
  double left_ = kTick;
};

}  // namespace palpate

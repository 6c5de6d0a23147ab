/// \file
/// Work budget of a tick for views of the scene.
#pragma once

#include <algorithm>
#include <cstddef>

namespace palpate {

/// Bounds the work of a tick on views of the scene: the next tick continues with the rest, so that the
/// duration of a tick does not depend on the size of the tool or the number of parts and Gaussians. It counts
/// work instead of time, so that a repeated run gives the same forces. A started operation is completed, and
/// may exceed the budget by one view.
class WorkBudget {
 public:
  /// In units of about 20 ns.
  static constexpr double kTick = 15500.0;

  void refill() { left_ = kTick; }
  bool is_spent() const { return left_ <= 0.0; }
  bool is_half_spent() const { return left_ <= 0.5 * kTick; }
  /// Spends the cost of a view. \param near Gaussians that were considered \param in_window, drawn see
  /// DepthView
  void spend_on_view(std::size_t near, std::size_t in_window, std::size_t drawn) {
    spend(kPerView + kPerNear * real(near) + kPerInWindow * real(in_window) + kPerDrawn * real(drawn));
  }
  /// Spends the cost of a surface fit to a view.
  void spend_on_fit() { spend(kPerFit); }
  /// Returns the number of Gaussians that a search of the index may visit.
  std::size_t search_limit() const {
    return static_cast<std::size_t>(std::max(left_ / kPerWalkedAtFirst, kLeastWalked));
  }
  /// \param walked Gaussians visited by a search of the index \param passed those of them that needed an
  /// exact check
  void spend_on_search(std::size_t walked, std::size_t passed) {
    spend(kPerSearch + kPerWalked * real(walked) + kPerPassed * real(passed));
  }
  /// \param found Gaussians found by a search and stored
  void spend_on_taking_up(std::size_t found) { spend(kPerFound * real(found)); }
  /// \param examined Gaussians of its group that a part was compared with \param taken those it took
  void spend_on_selection(std::size_t examined, std::size_t taken) {
    spend(kPerExamined * real(examined) + kPerTaken * real(taken));
  }
  /// Spends the cost of the contacts of a part. \param pairs number of exact checks, and of contacts found
  void spend_on_touch(std::size_t pairs) { spend(kPerTouch + kPerPair * real(pairs)); }
  /// Spends the cost of a contact of a part that starts inside an object.
  void spend_on_start() { spend(kPerStart); }
  /// Spends the cost of finding the materials of Gaussians. \param regions examined for each of them
  void spend_on_materials(std::size_t gaussians, std::size_t regions) {
    spend(real(gaussians) * (kPerMaterial + kPerRegion * real(regions)));
  }
  /// Returns true if the budget allows a motion constrained by so many planes: always if nothing has been
  /// spent.
  bool allows_motion(std::size_t planes) const { return left_ >= price_of_motion(planes); }
  void spend_on_motion(std::size_t planes) { spend(price_of_motion(planes)); }
  /// Spends the cost of moving a part by a step, with or without a view: 6 steps per tick with 256 parts.
  void spend_on_part() { spend(kPerPart); }

 private:
  static double real(std::size_t count) { return static_cast<double>(count); }
  /// At most half the budget of a tick, which leaves some for views along the motion.
  static double price_of_motion(std::size_t planes) {
    return std::min(kPerPlane * real(planes), 0.5 * kTick);
  }
  void spend(double units) { left_ -= units; }

  // Least squares of the times of ticks: of a plate of 256 parts, on a capture and flat on two planes, and of
  // a gripper, a disc and balls of 50 and 100 mm.
  static constexpr double kPerView = 150.0, kPerNear = 0.3, kPerInWindow = 1.2, kPerDrawn = 2.0;
  static constexpr double kPerFit = 250.0;
  static constexpr double kPerSearch = 10.0, kPerWalked = 0.3, kPerPassed = 0.1, kPerFound = 0.8;
  /// Cost of a search that has yet to find the suitable sample.
  static constexpr double kPerWalkedAtFirst = 1.2, kLeastWalked = 1000.0;
  static constexpr double kPerExamined = 0.1, kPerTaken = 1.2;
  static constexpr double kPerTouch = 50.0, kPerPair = 1.1, kPerStart = 10.0, kPerPlane = 35.0,
                          kPerPart = 7.0;
  /// A lookup takes 11 ns, and 2 to 6 ns more for each region.
  static constexpr double kPerMaterial = 1.0, kPerRegion = 0.25;
  double left_ = kTick;
};

}  // namespace palpate

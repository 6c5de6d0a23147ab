/// \file
/// Looking for contacts before the tool is there, on another thread.
#pragma once

#include <deque>
#include <optional>

#include <palpate/base/background_work.h>
#include <palpate/base/latest_value.h>
#include <palpate/collision/neighbourhood.h>

namespace palpate {

/// Finds the Neighbourhoods of tools that move, with a margin, for ContactTrackers on a servo thread, which
/// evaluate them at the pose of every tick (the paper's decoupling, section IV, without its stale force).
///
/// A neighbourhood reaches as far as the tool will move until the next but one is there, going on as it did,
/// and at least kLeastMargin on all sides; less where that is too much to go through in a tick.
///
/// add() before the threads begin. One thread calls take() and finish(); one calls want() and newest().
class Lookahead final : public BackgroundWork {
 public:
  /// Between a tracker and the thread that looks ahead for it.
  class Line {
   public:
    /// Of contacts in that precision; none: of what is drawn, see Neighbourhood::search_drawn().
    /// \param capacity see Neighbourhood
    Line(const SceneIndex& index, std::optional<Precision> precision, std::size_t capacity)
        : index_(index), precision_(precision), found_(capacity) {}

    /// \name The servo thread's. Neither waits nor takes memory.
    /// @{
    void want(const Ellipsoid& tool);
    /// What was found last; the same until the next call of want().
    Neighbourhood& newest() { return found_.front(); }
    /// @}

   private:
    friend class Lookahead;
    void take();
    void finish();

    const SceneIndex& index_;
    std::optional<Precision> precision_;
    LatestValue<Ellipsoid> wanted_;
    LatestValue<Neighbourhood> found_;
    Ellipsoid tool_;                                 ///< that was taken
    Eigen::Vector3d way_ = Eigen::Vector3d::Zero();  ///< since the one before. Unit: [m].
    double farthest_ = 0.0;  ///< that any of its points moved on that way, at most. Unit: [m].
    bool started_ = false;
    Ellipsoid known_;      ///< the tool that was searched around last
    double margin_ = 0.0;  ///< of that search; 0 if there was none. Unit: [m].
  };

  /// A line for tools in `index`, which must outlive it.
  Line& add(const SceneIndex& index, Precision precision, std::size_t capacity = Neighbourhood::kCapacity) {
    return lines_.emplace_back(index, precision, capacity);
  }
  /// The same, for what is drawn.
  Line& add_drawn(const SceneIndex& index, std::size_t capacity = Neighbourhood::kCapacity) {
    return lines_.emplace_back(index, std::nullopt, capacity);
  }

  void take() override;
  void finish() override;

  /// What a hand moves in a twentieth of a second from rest. Unit: [m].
  static constexpr double kLeastMargin = 0.01;
  /// Gaussians that are gone through in 10 us or so.
  static constexpr std::size_t kEasy = 1024;

 private:
  std::deque<Line> lines_;  ///< that cannot be moved
};

}  // namespace palpate

/// \file
/// Simulated hand that can be led by an external target.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include <palpate/device/simulated_device.h>

namespace palpate {

/// Target path of a simulated hand that follows its own path until it is led, then follows the external
/// target, and returns when released, always at the speed of a hand: the target may jump, and arrive at any
/// rate. It returns along the way it was led, without loops, since the straight way may pass through objects,
/// and resumes its own path where it left it; it returns straight only if its own path has moved elsewhere
/// meanwhile. One thread.
class LedHand {
 public:
  /// External target X_DH at a time; empty while the hand is not led.
  using Lead = std::function<std::optional<Pose>(double t)>;

  LedHand(HandPath own, Lead lead) : own_(std::move(own)), lead_(std::move(lead)) {}

  /// Returns the target at `t`. The own path is evaluated at the time spent on it, from the first t on.
  /// \returns X_DH \param t never decreases. Unit: [s].
  Pose operator()(double t);

  /// Speed towards the external target; a hand in contact moves at 1 m/s at most.
  static constexpr double kSpeed = 1.0;      ///< Unit: [m/s].
  static constexpr double kTurnSpeed = 6.0;  ///< Unit: [rad/s].
  /// Faster motion of the own path, beyond any hand, counts as a jump. Unit: [m/s], [rad/s].
  static constexpr double kJump = 10.0, kTurnJump = 150.0;
  /// Time constant of following a small change. Unit: [s].
  static constexpr double kFollow = 0.02;
  /// Least fraction of those speeds at the end of a motion.
  static constexpr double kLeastShare = 0.01;
  /// Return speed, that of an exploring hand; and spacing of the remembered places, larger on a way of more
  /// than 1024 of them. Unit: [m/s], [m].
  static constexpr double kBackSpeed = 0.5, kStride = 1e-3;

 private:
  /// Way from the place where the hand left its own path to its present one: places in order, in fixed
  /// storage.
  class Trail {
   public:
    bool empty() const { return size_ == 0; }
    const Pose& last() const { return places_[size_ - 1]; }
    void clear() { size_ = 0; }
    void drop_last() { --size_; }
    /// Adds a place. If the hand returns to an earlier place, the loop between is removed.
    void add(const Pose& pose);

   private:
    std::array<Pose, 1024> places_;
    std::size_t size_ = 0;
    double stride_ = kStride;
  };

  bool go_back(const Pose& own, double dt);

  HandPath own_;
  Lead lead_;
  Pose pose_;
  double t_ = 0.0;
  double own_t_ = 0.0;
  Trail trail_;
  Pose own_before_;
  bool led_before_ = false;
  bool started_ = false;
  bool away_ = false;  ///< from its own path
};

}  // namespace palpate

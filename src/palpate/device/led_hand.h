/// \file
/// A hand that someone else can lead.
#pragma once

#include <optional>

#include <palpate/device/simulated_device.h>

namespace palpate {

/// Where a simulated hand wants to be that goes its own way until it is led, follows who leads it, and goes
/// back to its own way when it is let go, at the speed of a hand throughout: what leads may jump, and come
/// at any rate, and its own way may go on elsewhere. One thread.
class LedHand {
 public:
  /// X_DH that it is led to at a time; nothing while nobody leads it.
  using Lead = std::function<std::optional<Pose>(double t)>;

  LedHand(HandPath own, Lead lead) : own_(std::move(own)), lead_(std::move(lead)) {}

  /// \returns X_DH \param t never falls. Unit: [s].
  Pose operator()(double t);

  /// Of a hand on its way to where it is led; a hand that touches moves at 1 m/s at most.
  static constexpr double kSpeed = 1.0;      ///< Unit: [m/s].
  static constexpr double kTurnSpeed = 6.0;  ///< Unit: [rad/s].
  /// Of its own way, that which is quicker goes on elsewhere: no hand is. Unit: [m/s], [rad/s].
  static constexpr double kJump = 10.0, kTurnJump = 150.0;
  /// In which it follows a small change. Unit: [s].
  static constexpr double kFollow = 0.02;
  /// Of those speeds, in the end of a way.
  static constexpr double kLeastShare = 0.01;

 private:
  HandPath own_;
  Lead lead_;
  Pose pose_;
  double t_ = 0.0;
  Pose own_before_;
  bool led_before_ = false;
  bool started_ = false;
  bool away_ = false;  ///< from its own way
};

}  // namespace palpate

/// \file
/// A hand that someone else can lead.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include <palpate/device/simulated_device.h>

namespace palpate {

/// Where a simulated hand wants to be that goes its own way until it is led, follows who leads it, and goes
/// back when it is let go, at the speed of a hand throughout: what leads may jump, and come at any rate. It
/// goes back the way it was led, without the rounds, since the straight one may lead through things, and goes
/// on from where it was taken; straight only to an own way that is elsewhere meanwhile. One thread.
class LedHand {
 public:
  /// X_DH that it is led to at a time; nothing while nobody leads it.
  using Lead = std::function<std::optional<Pose>(double t)>;

  LedHand(HandPath own, Lead lead) : own_(std::move(own)), lead_(std::move(lead)) {}

  /// Its own way is asked for the time that the hand has been on it, from the first t on. \returns X_DH
  /// \param t never falls. Unit: [s].
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
  /// Of a hand that goes back, as quick as one that explores; and how far apart the places are that it
  /// remembers, or more on a way of more than 1024 of them. Unit: [m/s], [m].
  static constexpr double kBackSpeed = 0.5, kStride = 1e-3;

 private:
  /// The way from where the hand was taken to where it is: places in order, in memory of its own.
  class Trail {
   public:
    bool empty() const { return size_ == 0; }
    const Pose& last() const { return places_[size_ - 1]; }
    void clear() { size_ = 0; }
    void drop_last() { --size_; }
    /// Where the hand comes back to an earlier place, what lies between is forgotten.
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
  bool away_ = false;  ///< from its own way
};

}  // namespace palpate

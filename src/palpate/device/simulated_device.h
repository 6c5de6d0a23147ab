/// \file
/// A device and the hand that holds it, in place of both.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <functional>

#include <palpate/servo/haptic_device.h>

namespace palpate {

/// A hand, coupled to the handle by a spring and a damper to where it wants to be.
struct HandProperties {
  double mass = 0.1;         ///< that moves with the handle. Unit: [kg]. >= 0
  double damping = 3.0;      ///< Unit: [N s/m]. >= 0
  double stiffness = 300.0;  ///< Unit: [N/m]. >= 0

  bool operator==(const HandProperties&) const = default;
};

/// A device's mechanics and electronics.
struct PlantProperties {
  double mass = 0.1;             ///< at the handle. Unit: [kg]. > 0
  double damping = 0.5;          ///< Unit: [N s/m]. >= 0
  double coulomb = 0.0;          ///< dry friction. Unit: [N]. >= 0
  double resolution = 0.0;       ///< of the encoders, at the handle; 0: exact. Unit: [m].
  double turn_resolution = 0.0;  ///< Unit: [rad].
  double delay = 0.0;            ///< from write() until the motors show it; at most kMostDelay. Unit: [s].
  double gyration = 0.03;        ///< radius that makes masses inertias and forces torques. Unit: [m]. > 0
};

/// X_DH that the hand wants the handle to be at, at a time, in the device's frame D. Must not fail; is called
/// by the thread of read().
using HandPath = std::function<Pose(double t)>;

/// A point mass with dry and viscous friction, and an inertia that turns likewise where the device has motors
/// for that (elsewhere the hand turns the handle freely), held by a hand:
///
///     (m_device + m_hand) x'' = F + k (x_hand - x) + b (x_hand' - x') - b_device x' - coulomb x' / |x'|
///
/// integrated implicitly in steps of kStep, so that every mass, hand and friction is stable, and a handle
/// that dry friction holds is at rest. F is what was written `delay` ago, no more than the motors can.
///
/// Time is the loop's: in virtual time all is the same at every run; in real time it follows the clock that
/// read() is given. Starts where the hand is at the first read(). Has nothing to connect: it is enabled from
/// its construction on. Where it senses no rotation it tells none.
class SimulatedDevice final : public HapticDevice {
 public:
  /// `path` must be good as long as the object is used.
  SimulatedDevice(const DeviceCapabilities& capabilities, const PlantProperties& plant,
                  const HandProperties& hand, HandPath path);

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  void enable() override;
  bool read(double t, DeviceReading& reading) override;
  void write(const Wrench& wrench) override;
  void stop() noexcept override { stopped_.store(true, std::memory_order_relaxed); }

  /// What the motors show at the time of the last read(): F_H_D, torque about the handle.
  Wrench motors() const;
  /// What the encoders do not tell: where the handle really is, X_DH, and its velocity V_DH.
  const Pose& pose() const { return pose_; }
  const Twist& velocity() const { return velocity_; }
  /// Of the hand on the handle, expressed in D. Unit: [N].
  const Eigen::Vector3d& hand_force() const { return hand_force_; }
  /// That the motors have done on the handle, ever. Unit: [J].
  double motor_work() const { return motor_work_; }

  static constexpr double kStep = 5e-5;        ///< Unit: [s].
  static constexpr double kMostDelay = 10e-3;  ///< Unit: [s].

 private:
  struct Written {
    double t = 0.0;
    Wrench wrench;
  };

  void step(double h);
  void turn(double h, const Eigen::Vector3d& torque, const Pose& wanted, const Eigen::Vector3d& wanted_spin);

  DeviceCapabilities capabilities_;
  PlantProperties plant_;
  HandProperties hand_;
  HandPath path_;
  bool started_ = false;
  double t_ = 0.0;        ///< of the state. Unit: [s].
  double read_at_ = 0.0;  ///< Unit: [s].
  Pose pose_, wanted_;
  Twist velocity_;
  Eigen::Vector3d hand_force_ = Eigen::Vector3d::Zero();
  double motor_work_ = 0.0;
  Pose told_;                        ///< of the last reading
  Twist told_velocity_;              ///< filtered differences, as drivers tell it
  std::array<Written, 128> writes_;  ///< a ring: at 10 kHz more than kMostDelay
  std::size_t written_ = 0;          ///< in all
  std::atomic<bool> stopped_ = false;
};

}  // namespace palpate

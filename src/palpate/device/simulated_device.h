/// \file
/// Simulated device and operator.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <functional>

#include <palpate/servo/haptic_device.h>

namespace palpate {

/// A hand: a mass on the handle, pulled to the target pose by a spring and a damper.
struct HandProperties {
  double mass = 0.1;         ///< moves with the handle. Unit: [kg]. >= 0
  double damping = 3.0;      ///< Unit: [N s/m]. >= 0
  double stiffness = 300.0;  ///< Unit: [N/m]. >= 0

  bool operator==(const HandProperties&) const = default;
};

/// A device's mechanics and electronics.
struct PlantProperties {
  double mass = 0.1;             ///< at the handle. Unit: [kg]. > 0
  double damping = 0.5;          ///< Unit: [N s/m]. >= 0
  double coulomb = 0.0;          ///< dry friction. Unit: [N]. >= 0
  double resolution = 0.0;       ///< of the encoders, at the handle; 0 = exact. Unit: [m].
  double turn_resolution = 0.0;  ///< Unit: [rad].
  double delay = 0.0;            ///< from write() until the motors apply it; at most kMostDelay. Unit: [s].
  double gyration = 0.03;  ///< radius that converts masses to inertias and forces to torques. Unit: [m]. > 0
};

/// Target pose X_DH of the hand at a time, in the device's frame D. Must not fail; called by the thread of
/// read().
using HandPath = std::function<Pose(double t)>;

/// A point mass with dry and viscous friction, held by a hand, and an inertia that rotates likewise if the
/// device has actuated rotation (otherwise the hand turns the handle freely):
///
///     (m_device + m_hand) x'' = F + k (x_hand - x) + b (x_hand' - x') - b_device x' - coulomb x' / |x'|
///
/// integrated implicitly in steps of kStep, so that every mass, hand and friction is stable, and a handle
/// that dry friction holds is at rest. F is the force written `delay` ago, clamped to the peak of the motors.
///
/// Uses the loop's time: in virtual time every run is identical; in real time it follows the clock passed to
/// read(). Starts at the pose of the hand at the first read(). Needs no connection: it is enabled from
/// construction on. Reports no rotation if it senses none.
class SimulatedDevice final : public HapticDevice {
 public:
  /// `path` must be valid as long as the object is used.
  SimulatedDevice(const DeviceCapabilities& capabilities, const PlantProperties& plant,
                  const HandProperties& hand, HandPath path);

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  void enable() override;
  bool read(double t, DeviceReading& reading) override;
  void write(const Wrench& wrench) override;
  void stop() noexcept override { stopped_.store(true, std::memory_order_relaxed); }

  /// Wrench of the motors at the time of the last read(): F_H_D, torque about the handle.
  Wrench motors() const;
  /// True pose X_DH of the handle, without encoder error, and its velocity V_DH.
  const Pose& pose() const { return pose_; }
  const Twist& velocity() const { return velocity_; }
  /// Force of the hand on the handle, expressed in D. Unit: [N].
  const Eigen::Vector3d& hand_force() const { return hand_force_; }
  /// Total work of the motors on the handle. Unit: [J].
  double motor_work() const { return motor_work_; }

  static constexpr double kStep = 5e-5;        ///< Unit: [s].
  static constexpr double kMostDelay = 10e-3;  ///< Unit: [s].
  /// Time constant of the reported velocity: about 100 Hz, as in drivers. Unit: [s].
  static constexpr double kVelocityFilter = 1.6e-3;
  /// Longest gap that is simulated: after a longer one the plant restarts at the present time. Unit: [s].
  static constexpr double kLongestGap = 0.1;

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
  Pose told_;                        ///< as reported in the last reading
  Twist told_velocity_;              ///< filtered differences, as reported by drivers
  std::array<Written, 128> writes_;  ///< ring buffer: at 10 kHz more than kMostDelay
  std::size_t written_ = 0;          ///< number of writes in all
  std::atomic<bool> stopped_ = false;
};

}  // namespace palpate

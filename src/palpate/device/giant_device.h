/// \file
/// Simulated room-scale device of the admittance type.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <random>

#include <palpate/device/joint_plant.h>
#include <palpate/kinematics/joint_motion.h>
#include <palpate/servo/least_admittance.h>
#include <palpate/servo/motion_device.h>

namespace palpate {

/// Error model of the force sensor.
struct ForceSensorProperties {
  double noise = 0.02, torque_noise = 0.002;  ///< of each axis, standard deviation. Unit: [N], [N m].
  Wrench bias;                                ///< F_H_D, torque about the TCP
  Wrench drift;                               ///< of the bias. Unit: [N/s], [N m/s].
  double lag = 2e-3;                          ///< of its filter. Unit: [s]. >= 0
  double range = 150.0, torque_range = 15.0;  ///< of each axis: saturates here. Unit: [N], [N m].
};

/// Properties of drives, sensor and motion of the device.
struct GiantProperties {
  JointPlantProperties drives;
  ForceSensorProperties sensor;
  double delay = 2e-3;       ///< from move() until the drives follow it; at most kMostDelay. Unit: [s].
  double resolution = 2e-6;  ///< of the encoders at the joints; 0 = exact. Unit: [m], [rad].
  JointMotionOptions motion;
};

/// A serial chain held by a simulated hand, as a device that measures the hand's wrench and follows a
/// commanded motion, which JointMotion converts to joint motion within limits. Readings come from encoders
/// and sensor; every read() has a new one.
///
/// Uses the loop's time, as SimulatedDevice. Without a move() for kWatchdog, and after stop(), the joints
/// brake.
class GiantDevice final : public MotionDevice {
 public:
  /// \param chain checked \param plant created for this chain; advanced by this object alone \param start
  /// X_DH of the TCP, within reach \throws Error if it is not.
  GiantDevice(const SerialChain& chain, std::unique_ptr<JointPlant> plant, const GiantProperties& properties,
              const Pose& start, std::uint64_t seed = 1);

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double t, MotionReading& reading) override;
  MotionAnswer move(const MotionSetpoint& motion, double dt) override;
  void stop() noexcept override { stopped_.store(true, std::memory_order_relaxed); }

  /// True pose of the TCP, X_DH, and true wrench of the hand on it, F_H_D, torque about the TCP.
  Pose pose() const;
  Wrench hand() const { return plant_->hand(); }
  const JointMotion& joints() const { return motion_; }

  static constexpr double kMostDelay = 0.012;  ///< Unit: [s].
  static constexpr double kWatchdog = 0.05;    ///< Unit: [s].

 private:
  struct Told {
    double t = 0.0;
    JointVector q;
  };

  void advance(double t);
  Wrench sensed(double dt);

  SerialChain chain_;
  GiantProperties properties_;
  DeviceCapabilities capabilities_;
  std::unique_ptr<JointPlant> plant_;
  JointMotion motion_;
  mutable ChainKinematics kinematics_;
  bool started_ = false;
  double t_ = 0.0, read_at_ = 0.0, moved_at_ = 0.0;
  bool watchdog_braked_ = false;  ///< up to t_, without a move()
  std::array<Told, 64> told_;     ///< ring buffer of commands from move(), for the delay
  std::size_t told_count_ = 0, shown_ = 0;
  Pose seen_;
  Twist velocity_;
  Wrench filtered_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::atomic<bool> stopped_ = false;
};

/// Returns the loop model of this device along an axis, for an AdmittanceLoop: delay, lags, and the slowest
/// mode of gears and belts. Contact and hand are left at zero.
AdmittanceLoopModel loop_model(const SerialChain& chain, const GiantProperties& properties);

}  // namespace palpate

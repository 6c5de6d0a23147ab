/// \file
/// Admittance controller: virtual mass and damper of an admittance-type device.
#pragma once

#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <palpate/geometry/pose.h>
#include <palpate/servo/device_pose.h>
#include <palpate/servo/limited_axis.h>

namespace palpate {

/// Virtual mass and damping for each axis of the device's frame; rotation is about the TCP.
struct Admittance {
  Eigen::Vector3d mass = Eigen::Vector3d::Constant(1.5);             ///< M. Unit: [kg]. > 0
  Eigen::Vector3d damping = Eigen::Vector3d::Constant(25.0);         ///< D. Unit: [N s/m]. >= 0
  Eigen::Vector3d inertia = Eigen::Vector3d::Constant(0.02);         ///< Unit: [kg m^2]. > 0
  Eigen::Vector3d angular_damping = Eigen::Vector3d::Constant(0.2);  ///< Unit: [N m s/rad]. >= 0
  /// B, added to D only along the force of the scene: a mass on a stiff scene comes to rest but slides as in
  /// free space. Unit: [N s/m]. >= 0
  double contact_damping = 0.0;
};

/// Motion limits along and about each axis of the device's frame, each axis by itself.
struct MotionLimits {
  double velocity = 1.2, acceleration = 6.0, jerk = 300.0;  ///< Unit: [m/s], ... > 0
  double angular_velocity = 3.0, angular_acceleration = 25.0,
         angular_jerk = 1500.0;  ///< Unit: [rad/s], ... > 0
  /// Bounds of the TCP; empty = unbounded. Unit: [m].
  Eigen::AlignedBox3d workspace;

  AxisLimits along(Eigen::Index axis) const;
  AxisLimits about() const { return {angular_jerk, angular_acceleration, angular_velocity}; }
  /// Upper bound of the time to come to rest from any state within the limits. Unit: [s].
  double stop_time() const;
};

/// Motion setpoint of the TCP at one instant: X_DH, V_DH and its derivative, in the device's frame D.
struct MotionSetpoint {
  DevicePose pose;  ///< X_DH
  Twist velocity, acceleration;
  bool still = false;  ///< the TCP is at rest, and no other part of the device is to move either
};

/// M a = F_user + F_scene - D v - B n n^T v along each axis of the device's frame, n the direction of
/// F_scene, and likewise about it without B, within MotionLimits. B is ramped within kDampingTime. The
/// integration rule is trapezoidal in D v, so that it is stable for every M > 0 and D:
///
///     a' = (F - D (v + a dt / 2)) / (M + D dt / 2)        v' = v + (a + a') dt / 2
///
/// and the output never exceeds a limit, whatever the forces (stepped(), axis by axis: a limited motion may
/// differ in direction from the force).
///
/// Parameters change slowly: M' <= D. The energy of the virtual mass is M v^2 / 2, and its rate F v - (D - M'
/// / 2) v^2, so that a mass that grows during motion dissipates at least half of D v^2 and generates no
/// energy (Ferraguti, Secchi and Fantuzzi 2013).
///
/// One object per thread. Does not allocate or throw.
class AdmittanceController {
 public:
  AdmittanceController(const Admittance& admittance, const MotionLimits& limits);

  /// Starts at rest at X_DH. A start outside of the workspace is moved in slowly.
  void start(const DevicePose& pose);
  /// Sets the motion to `actual`, that of the device where it could not follow. Its acceleration is limited
  /// to that of the controller.
  void follow(const MotionSetpoint& actual);

  /// Sets the target admittance, which is approached as described above.
  void set(const Admittance& admittance) { wanted_ = admittance; }
  /// The admittance now in effect.
  const Admittance& admittance() const { return now_; }

  /// Advances by `dt` under wrenches F_H_D that were measured at its beginning, torque about the TCP. \pre
  /// finite wrenches \param dt Unit: [s]. > 0
  const MotionSetpoint& step(const Wrench& user, const Wrench& scene, double dt);
  /// Advances by `dt` while braking; at rest within MotionLimits::stop_time(), whatever the sequence of `dt`.
  /// \param travel longest time whose travel the pose takes: after a longer gap the velocity has fallen by
  /// `dt`, but the pose does not jump. Unit: [s].
  const MotionSetpoint& brake(double dt, double travel = std::numeric_limits<double>::infinity());

  const MotionSetpoint& motion() const { return motion_; }
  bool at_rest() const;
  const MotionLimits& limits() const { return limits_; }

  static constexpr double kDampingTime = 0.1;  ///< time constant of damping changes. Unit: [s].

 private:
  using Axes = std::array<AxisState, 3>;

  void change(double dt);
  Eigen::Vector3d damped(const Eigen::Vector3d& scene, double dt);
  void tell(const Axes& turned);

  MotionLimits limits_;
  Admittance now_, wanted_;
  double contact_damping_ = 0.0;  ///< B in effect. Unit: [N s/m].
  Axes along_;
  MotionSetpoint motion_;
};

}  // namespace palpate

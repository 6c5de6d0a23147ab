/// \file
/// From forces to motion: the virtual mass and damper of an admittance-type device.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <palpate/geometry/pose.h>
#include <palpate/servo/device_pose.h>
#include <palpate/servo/limited_axis.h>

namespace palpate {

/// What a hand feels, for each axis of the device's frame; in rotation about the TCP.
struct Admittance {
  Eigen::Vector3d mass = Eigen::Vector3d::Constant(1.5);             ///< M. Unit: [kg]. > 0
  Eigen::Vector3d damping = Eigen::Vector3d::Constant(25.0);         ///< D. Unit: [N s/m]. >= 0
  Eigen::Vector3d inertia = Eigen::Vector3d::Constant(0.02);         ///< Unit: [kg m^2]. > 0
  Eigen::Vector3d angular_damping = Eigen::Vector3d::Constant(0.2);  ///< Unit: [N m s/rad]. >= 0
  /// B, besides D and along the force of the scene alone, so that a mass on a stiff scene comes to rest, and
  /// slides as it does in free space. Unit: [N s/m]. >= 0
  double contact_damping = 0.0;
};

/// What motion must keep to, along and about each axis of the device's frame by itself.
struct MotionLimits {
  double velocity = 1.2, acceleration = 6.0, jerk = 300.0;  ///< Unit: [m/s], ... > 0
  double angular_velocity = 3.0, angular_acceleration = 25.0,
         angular_jerk = 1500.0;  ///< Unit: [rad/s], ... > 0
  /// Of the TCP; empty: no bounds. Unit: [m].
  Eigen::AlignedBox3d workspace;

  AxisLimits along(Eigen::Index axis) const;
  AxisLimits about() const { return {angular_jerk, angular_acceleration, angular_velocity}; }
  /// The longest that it takes to come to rest from within the limits. Unit: [s].
  double stop_time() const;
};

/// A motion of the TCP at one instant, for a device to follow: X_DH, V_DH and its derivative, in the device's
/// frame D.
struct MotionSetpoint {
  DevicePose pose;  ///< X_DH
  Twist velocity, acceleration;
  bool still = false;  ///< it is at rest, and nothing else of the device is to move either
};

/// M a = F_user + F_scene - D v - B n n^T v along each axis of the device's frame, n the direction of
/// F_scene, and likewise about it without B, within MotionLimits. B comes and goes within kDampingTime. The
/// rule is trapezoidal in D v, so that every M > 0 and D are stable by themselves:
///
///     a' = (F - D (v + a dt / 2)) / (M + D dt / 2)        v' = v + (a + a') dt / 2
///
/// and what leaves never exceeds a limit, whatever the forces are (stepped(), axis by axis: a motion that is
/// limited goes in another direction than the force).
///
/// Parameters change slowly: M' <= D. The energy of the virtual mass is M v^2 / 2, and its rate F v - (D - M'
/// / 2) v^2, so that a mass that grows under way takes from the hand no less than half of what it should,
/// and gives nothing (Ferraguti, Secchi and Fantuzzi 2013).
///
/// One object a thread. Takes nothing from the heap, throws nothing.
class AdmittanceController {
 public:
  AdmittanceController(const Admittance& admittance, const MotionLimits& limits);

  /// At rest at X_DH. What is outside of the workspace is let in, slowly.
  void start(const DevicePose& pose);
  /// The motion is that of the device, where it could not follow: X_DH and V_DH as they are.
  void follow(const DevicePose& pose, const Twist& velocity, double dt);

  /// What is aimed for; see above.
  void set(const Admittance& admittance) { wanted_ = admittance; }
  /// In effect now.
  const Admittance& admittance() const { return now_; }

  /// After `dt`, with wrenches F_H_D that were measured at its beginning, torque about the TCP. \pre they are
  /// finite \param dt Unit: [s]. > 0
  const MotionSetpoint& step(const Wrench& user, const Wrench& scene, double dt);
  /// After `dt` of coming to rest, over in MotionLimits::stop_time().
  const MotionSetpoint& brake(double dt);

  const MotionSetpoint& motion() const { return motion_; }
  bool at_rest() const;
  const MotionLimits& limits() const { return limits_; }

  static constexpr double kDampingTime = 0.1;  ///< in which dampings go to what is wanted. Unit: [s].

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

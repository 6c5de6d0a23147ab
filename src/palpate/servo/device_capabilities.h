/// \file
/// What a haptic device can do.
#pragma once

#include <string>

namespace palpate {

/// Of how many axes, 0 to 3 of each kind.
struct DeviceAxes {
  int translation = 3;
  int rotation = 3;
};

/// How the damping of a device is known.
enum class DampingSource {
  kUnknown,    ///< it is then credited as 0
  kMeasured,   ///< on this device, or on one of its kind
  kDataSheet,  ///< stated by the maker
  kSimulated,  ///< the device is a simulation, and this is what its plant has
};

/// What a device takes, and what it measures in return.
enum class Causality {
  kImpedance,   ///< takes a wrench, measures the hand's motion
  kAdmittance,  ///< takes a motion, measures the hand's wrench: see MotionDevice and AdmittanceLoop
};

/// From the maker's data sheet, or measured. All limits are upper bounds: nothing sends more, whatever a
/// force model asks for. What is not known is 0.
struct DeviceCapabilities {
  std::string name;
  Causality kind = Causality::kImpedance;
  double force_max = 0.0;   ///< peak. Unit: [N]. > 0
  double torque_max = 0.0;  ///< peak; 0 if it has no motors for the orientation. Unit: [N m].
  /// What the motors hold for ever, at most the peak; 0: as much as the peak. Above it SafetyGovernor keeps
  /// to SustainedLimit. Unit: [N], [N m].
  double force_sustained = 0.0, torque_sustained = 0.0;
  DeviceAxes sensed;  ///< a device that senses no rotation tells one orientation for ever
  /// Of each kind as many as are sensed, or none; rotation > 0 where torque_max is, and nowhere else.
  DeviceAxes actuated{3, 0};
  double stiffness_max = 0.0;  ///< of a wall that it shows without buzzing, as the maker says. Unit: [N/m].
  double damping_max = 0.0;    ///< that it can show. Unit: [N s/m].
  /// Its own viscous damping, that passivity may count on: at most what it has in its least damped pose and
  /// direction. 0 unless damping_source says how it is known. Unit: [N s/m].
  double damping = 0.0;
  DampingSource damping_source = DampingSource::kUnknown;
  double delay = 0.0;  ///< from write() until the motors show it; counts against the margin. Unit: [s].
  /// Time without a write() after which the device itself turns its motors off, also where this program has
  /// died; 0: it has no such watchdog, or nobody knows. Unit: [s].
  double watchdog = 0.0;
  double workspace = 0.0;  ///< radius of the largest ball in it. Unit: [m].
  double rate = 1000.0;    ///< of its readings. Unit: [Hz]. > 0
};

/// \throws Error that names the device and the first figure that is out of its range or contradicts another.
void check_capabilities(const DeviceCapabilities& device);

}  // namespace palpate

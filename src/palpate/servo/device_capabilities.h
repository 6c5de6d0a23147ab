/// \file
/// Capabilities of a haptic device.
#pragma once

#include <string>

namespace palpate {

/// Numbers of axes, 0 to 3 of each kind.
struct DeviceAxes {
  int translation = 3;
  int rotation = 3;
};

/// Source of a device's damping figure.
enum class DampingSource {
  kUnknown,    ///< credited as 0
  kMeasured,   ///< on this device or one of the same model
  kDataSheet,  ///< stated by the manufacturer
  kSimulated,  ///< damping of the plant of a simulated device
};

/// Causality: which quantity is commanded and which is measured.
enum class Causality {
  kImpedance,   ///< takes a wrench, measures the hand's motion
  kAdmittance,  ///< takes a motion, measures the hand's wrench: see MotionDevice and AdmittanceLoop
};

/// Figures from the manufacturer's data sheet, or measured. All limits are upper bounds: no more is ever
/// sent, whatever a force model requests. Unknown figures are 0.
struct DeviceCapabilities {
  std::string name;
  Causality kind = Causality::kImpedance;
  double force_max = 0.0;   ///< peak. Unit: [N]. > 0
  double torque_max = 0.0;  ///< peak; 0 = no actuated rotation. Unit: [N m].
  /// Sustained limits (the motors can hold them indefinitely), at most the peak; 0 = equal to the peak. Above
  /// them SafetyGovernor applies SustainedLimit. Unit: [N], [N m].
  double force_sustained = 0.0, torque_sustained = 0.0;
  DeviceAxes sensed;  ///< without sensed rotation, the reported orientation is constant
  /// Of each kind as many as are sensed, or none; rotation > 0 if and only if torque_max > 0.
  DeviceAxes actuated{3, 0};
  double stiffness_max =
      0.0;  ///< of a wall that it renders without buzzing, according to the manufacturer. Unit: [N/m].
  double damping_max = 0.0;  ///< that it can render. Unit: [N s/m].
  /// Its own viscous damping, credited by the passivity control: at most that of its least damped pose and
  /// direction. 0 unless damping_source names a source. Unit: [N s/m].
  double damping = 0.0;
  double angular_damping = 0.0;  ///< likewise, about its axes. Unit: [N m s/rad].
  DampingSource damping_source = DampingSource::kUnknown;
  double delay =
      0.0;  ///< from write() until the motors apply the wrench; reduces the stability margin. Unit: [s].
  /// Time without a write() after which the device itself turns its motors off, even if this program has
  /// died; 0 = no such watchdog, or unknown. Unit: [s].
  double watchdog = 0.0;
  double workspace = 0.0;  ///< radius of the largest inscribed ball. Unit: [m].
  double rate = 1000.0;    ///< of its readings. Unit: [Hz]. > 0
};

/// Checks the figures. \throws Error that names the device and the first figure that is out of range or
/// contradicts another.
void check_capabilities(const DeviceCapabilities& device);

}  // namespace palpate

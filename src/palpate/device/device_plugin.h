/// \file
/// C interface of device plug-ins: shared libraries that `palpate run --device plugin:PATH.so` loads. Plain C
/// without other parts of Palpate; docs/devices.md says how to build one. Drivers in C++ that implement
/// HapticDevice export it with palpate/device/export_device.h instead.
///
/// SI units. Poses, twists and wrenches are of the handle in the device's own right-handed frame; torques act
/// about the handle's origin. Functions are called as HapticDevice (palpate/servo/haptic_device.h) says:
/// functions of the owner's thread may block, functions of the loop's thread (wait, read, write) do not
/// allocate, lock or log, and stop and status may be called by any thread or signal handler at any time. No
/// function may throw.
#ifndef PALPATE_DEVICE_PLUGIN_H
#define PALPATE_DEVICE_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Version of the interface below; any change of layout changes the number.
#define PALPATE_DEVICE_PLUGIN_VERSION 2u
/// Name of the one symbol that a plug-in exports.
#define PALPATE_DEVICE_PLUGIN_SYMBOL "palpate_device_plugin"

/// Values of DeviceStatus.
enum PalpateDeviceStatus {
  PALPATE_DEVICE_CLOSED = 0,
  PALPATE_DEVICE_NEEDS_CALIBRATION = 1,
  PALPATE_DEVICE_OPEN = 2,
  PALPATE_DEVICE_ENABLED = 3,
  PALPATE_DEVICE_FAULT = 4
};

/// Values of DampingSource.
enum PalpateDampingSource {
  PALPATE_DAMPING_UNKNOWN = 0,
  PALPATE_DAMPING_MEASURED = 1,
  PALPATE_DAMPING_DATA_SHEET = 2,
  PALPATE_DAMPING_SIMULATED = 3
};

/// DeviceCapabilities. Unknown figures are 0.
typedef struct PalpateDeviceCapabilities {
  char name[64];            ///< null-terminated
  double force_max;         ///< peak. Unit: [N]. > 0
  double torque_max;        ///< peak; 0: no motors for the orientation. Unit: [N m].
  double force_sustained;   ///< sustained limit; 0 = equal to the peak. Unit: [N].
  double torque_sustained;  ///< likewise. Unit: [N m].
  double stiffness_max;     ///< Unit: [N/m].
  double damping_max;       ///< Unit: [N s/m].
  double damping;           ///< own viscous damping, credited by the passivity control. Unit: [N s/m].
  double angular_damping;   ///< likewise, about its axes. Unit: [N m s/rad].
  double delay;             ///< from write until the motors apply it. Unit: [s].
  double watchdog;          ///< time without a write after which the motors turn off. Unit: [s].
  double workspace;         ///< radius of the largest inscribed ball. Unit: [m].
  double rate;              ///< of its readings. Unit: [Hz]. > 0
  int32_t sensed_translation, sensed_rotation;      ///< axes, 0 to 3
  int32_t actuated_translation, actuated_rotation;  ///< axes, 0 to 3
  int32_t damping_source;                           ///< a PalpateDampingSource
  int32_t reserved;                                 ///< 0
} PalpateDeviceCapabilities;

/// DeviceReading.
typedef struct PalpateDeviceReading {
  double t;                    ///< when it was measured, on the clock of read's `t`. Unit: [s].
  double position[3];          ///< Unit: [m].
  double orientation[4];       ///< unit quaternion w, x, y, z: handle to device
  double linear_velocity[3];   ///< Unit: [m/s].
  double angular_velocity[3];  ///< Unit: [rad/s].
  uint32_t hand;               ///< changes with the hand, or after a disconnection
  uint32_t buttons;            ///< one bit each
} PalpateDeviceReading;

/// Wrench on the handle.
typedef struct PalpateDeviceWrench {
  double force[3];   ///< Unit: [N].
  double torque[3];  ///< Unit: [N m].
} PalpateDeviceWrench;

/// Function table of a plug-in. Only members marked "may be null" may be null. `error` receives one
/// null-terminated line for a person, of at most `size` bytes.
typedef struct PalpateDevicePlugin {
  uint32_t version;  ///< PALPATE_DEVICE_PLUGIN_VERSION, as compiled
  uint32_t size;     ///< sizeof(PalpateDevicePlugin), as compiled

  /// \name Owner's thread
  /// @{
  /// Creates a device, not open yet. \param arguments text after the plug-in's name; "" if there is none.
  /// \returns null if it cannot be created; `error` then says why.
  void* (*create)(const char* arguments, char* error, size_t size);
  /// Closes and deletes it.
  void (*destroy)(void* device);
  /// These functions return 0, or another number on failure; `error` then says what to do.
  int (*open)(void* device, char* error, size_t size);
  int (*calibrate)(void* device, char* error, size_t size);  ///< may be null: no calibration needed
  int (*enable)(void* device, char* error, size_t size);
  void (*close)(void* device);
  /// Valid once the device is open, and constant while it is.
  void (*capabilities)(void* device, PalpateDeviceCapabilities* capabilities);
  /// @}

  /// \name Loop's thread
  /// @{
  /// \returns 1 and fills in `reading` if there is a new one; else 0. \param t now. Unit: [s].
  int (*read)(void* device, double t, PalpateDeviceReading* reading);
  /// Waits for a reading, at most `seconds`; may be null: the loop waits by itself. Unit: [s].
  void (*wait)(void* device, double seconds);
  void (*write)(void* device, const PalpateDeviceWrench* wrench);
  /// @}

  /// \name Any thread
  /// @{
  void (*stop)(void* device);
  /// \returns a PalpateDeviceStatus. \param text set to a short explanation, of static lifetime.
  int (*status)(void* device, const char** text);
  /// @}
} PalpateDevicePlugin;

/// Returns the plug-in, of static lifetime; null if it does not support `host_version`, the version that the
/// program was compiled with.
const PalpateDevicePlugin* palpate_device_plugin(uint32_t host_version);

#ifdef __cplusplus
}
#endif

#endif  // PALPATE_DEVICE_PLUGIN_H

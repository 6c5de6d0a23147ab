/// \file
/// C interface of device plug-ins: shared libraries that `palpate run --device plugin:PATH.so` loads. Plain
/// C, needs nothing else of Palpate; docs/devices.md says how to build one. Drivers in C++ that implement
/// HapticDevice export it with palpate/device/export_device.h instead.
///
/// SI units. Poses, twists and wrenches are of the handle in the device's own right-handed frame; torques act
/// about the handle's origin. Functions are called as HapticDevice (palpate/servo/haptic_device.h) says:
/// those of the owner's thread may block, those of the loop's thread (wait, read, write) neither allocate,
/// lock nor log, and stop and status may be called by any thread or signal handler at any time. No function
/// may throw.
#ifndef PALPATE_DEVICE_PLUGIN_H
#define PALPATE_DEVICE_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Version of everything below; another number: another layout.
#define PALPATE_DEVICE_PLUGIN_VERSION 1u
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

/// DeviceCapabilities. What is not known is 0.
typedef struct PalpateDeviceCapabilities {
  char name[64];            ///< ends with 0
  double force_max;         ///< peak. Unit: [N]. > 0
  double torque_max;        ///< peak; 0: no motors for the orientation. Unit: [N m].
  double force_sustained;   ///< what the motors hold for ever; 0: as the peak. Unit: [N].
  double torque_sustained;  ///< likewise. Unit: [N m].
  double stiffness_max;     ///< Unit: [N/m].
  double damping_max;       ///< Unit: [N s/m].
  double damping;           ///< own viscous damping that passivity may count on. Unit: [N s/m].
  double delay;             ///< from write until the motors show it. Unit: [s].
  double watchdog;          ///< without a write, after which it turns its motors off. Unit: [s].
  double workspace;         ///< radius of the largest ball in it. Unit: [m].
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
  uint32_t hand;               ///< another number: another hand, or the device was away
  uint32_t buttons;            ///< a bit each
} PalpateDeviceReading;

/// Wrench on the handle.
typedef struct PalpateDeviceWrench {
  double force[3];   ///< Unit: [N].
  double torque[3];  ///< Unit: [N m].
} PalpateDeviceWrench;

/// What a plug-in exports. Members that "may be null" are; all others must be there. `error` takes one line
/// for a person, which ends with 0, within `size` bytes.
typedef struct PalpateDevicePlugin {
  uint32_t version;  ///< PALPATE_DEVICE_PLUGIN_VERSION, as compiled
  uint32_t size;     ///< sizeof(PalpateDevicePlugin), as compiled

  /// \name Owner's thread
  /// @{
  /// A device, not open yet. \param arguments what follows the plug-in's name; "" if nothing does. \returns
  /// null if it cannot be made; `error` then says why.
  void* (*create)(const char* arguments, char* error, size_t size);
  /// Closes and deletes it.
  void (*destroy)(void* device);
  /// These return 0, or another number where they fail; `error` then says what to do.
  int (*open)(void* device, char* error, size_t size);
  int (*calibrate)(void* device, char* error, size_t size);  ///< may be null: it never needs that
  int (*enable)(void* device, char* error, size_t size);
  void (*close)(void* device);
  /// Known once it is open, and the same for as long.
  void (*capabilities)(void* device, PalpateDeviceCapabilities* capabilities);
  /// @}

  /// \name Loop's thread
  /// @{
  /// \returns 1 and fills `reading` in if there is a new one; else 0. \param t now. Unit: [s].
  int (*read)(void* device, double t, PalpateDeviceReading* reading);
  /// Waits for a reading, for `seconds` at most; may be null: the loop waits by itself. Unit: [s].
  void (*wait)(void* device, double seconds);
  void (*write)(void* device, const PalpateDeviceWrench* wrench);
  /// @}

  /// \name Any thread
  /// @{
  void (*stop)(void* device);
  /// \returns a PalpateDeviceStatus. \param text set to why, in a few words: text that lives for ever.
  int (*status)(void* device, const char** text);
  /// @}
} PalpateDevicePlugin;

/// The plug-in; what it points to lives for ever. Null if it cannot serve `host_version`, the version that
/// the program was compiled with.
const PalpateDevicePlugin* palpate_device_plugin(uint32_t host_version);

#ifdef __cplusplus
}
#endif

#endif  // PALPATE_DEVICE_PLUGIN_H

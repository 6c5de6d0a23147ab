/// \file
/// Playback device: a recorded hand motion as a haptic device.
#pragma once

#include <palpate/record/trajectory.h>
#include <palpate/servo/haptic_device.h>

namespace palpate {

/// Reports the poses of a trajectory at their times and ignores all forces: the live counterpart of an
/// offline `replay` run. The trajectory begins at the first read(); after its end the last pose is reported
/// for ever.
class PlaybackDevice final : public HapticDevice {
 public:
  /// `capabilities` are those of the represented device. \pre the trajectory is not empty
  PlaybackDevice(const DeviceCapabilities& capabilities, Trajectory trajectory);

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double t, DeviceReading& reading) override;
  void write(const Wrench&) override {}

  /// Duration from the first pose to the last. Unit: [s].
  double length() const { return trajectory_.back().t - trajectory_.front().t; }

 private:
  DeviceCapabilities capabilities_;
  Trajectory trajectory_;
  bool started_ = false;
  double begin_ = 0.0;  ///< time of the first reading
  DeviceReading last_;
};

}  // namespace palpate

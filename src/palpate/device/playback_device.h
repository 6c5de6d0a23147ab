/// \file
/// A recorded hand as a device.
#pragma once

#include <palpate/record/trajectory.h>
#include <palpate/servo/haptic_device.h>

namespace palpate {

/// Tells the poses of a trajectory at their times, and takes every force without a move: what a run of
/// `replay` is offline, live. The trajectory begins at the first read(), and its last pose is told for ever
/// after.
class PlaybackDevice final : public HapticDevice {
 public:
  /// `capabilities` are those of the device that it stands for. \pre the trajectory is not empty
  PlaybackDevice(const DeviceCapabilities& capabilities, Trajectory trajectory);

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double t, DeviceReading& reading) override;
  void write(const Wrench&) override {}

  /// From the first pose to the last. Unit: [s].
  double length() const { return trajectory_.back().t - trajectory_.front().t; }

 private:
  DeviceCapabilities capabilities_;
  Trajectory trajectory_;
  bool started_ = false;
  double begin_ = 0.0;  ///< time of the first reading
  DeviceReading last_;
};

}  // namespace palpate

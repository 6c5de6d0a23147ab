#include <palpate/device/playback_device.h>

#include <palpate/device/hand_path.h>
#include <palpate/record/playback.h>

namespace palpate {

PlaybackDevice::PlaybackDevice(const DeviceCapabilities& capabilities, Trajectory trajectory)
    : capabilities_(capabilities), trajectory_(std::move(trajectory)) {}

bool PlaybackDevice::read(double t, DeviceReading& reading) {
  if (!started_) begin_ = t;
  if (started_ && !(t > last_.t)) return false;
  const Pose pose = pose_at(trajectory_, trajectory_.front().t + (t - begin_));
  const Twist velocity =
      started_ ? velocity_between({last_.t, last_.pose.in_device_frame(), {}}, {t, pose, {}}) : Twist{};
  reading = last_ = {t, DevicePose(pose), velocity};
  started_ = true;
  return true;
}

}  // namespace palpate

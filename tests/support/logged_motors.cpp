// A driver, exported as a plug-in, that keeps in the file of its argument whether its motors pull ('1') or
// not ('0'): it outlives the process. The handle goes down by itself from 50 mm above the origin to 5 mm,
// stays for 3 s and goes up again, over and over: a fault, as of late ticks, must not leave it below without
// force. Once the file's second byte is '!', the driver calls itself without end; once it is 's', a write
// takes longer than a tick.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <unistd.h>

#include <palpate/device/export_device.h>
#include <palpate/servo/haptic_device.h>

namespace {

class LoggedMotors final : public palpate::HapticDevice {
 public:
  explicit LoggedMotors(const std::string& path) : file_(::open(path.c_str(), O_RDWR | O_CREAT, 0600)) {
    if (file_ < 0) throw std::runtime_error(path + " cannot be written");
    capabilities_.name = "logged-motors";
    capabilities_.force_max = 10.0;
  }
  ~LoggedMotors() override { ::close(file_); }

  void enable() override {
    stopped_ = false;
    HapticDevice::enable();
  }
  void close() noexcept override {
    stop();
    HapticDevice::close();
  }
  const palpate::DeviceCapabilities& capabilities() const override { return capabilities_; }

  bool read(double t, palpate::DeviceReading& reading) override {
    if (::pread(file_, &asked_, 1, 1) == 1 && asked_ == '!') return recur(1) > 0;
    if (!(t > last_)) return false;
    last_ = t;
    if (first_ < 0.0) first_ = t;
    palpate::Pose pose;
    const double phase = std::fmod(t - first_, 8.0);
    pose.position.z() = std::clamp(0.05 - 0.02 * std::min(phase, 7.5 - phase), 0.005, 0.05);
    reading.t = t;
    reading.pose = palpate::DevicePose(pose);
    return true;
  }
  void write(const palpate::Wrench& wrench) override {
    if (stopped_) return;
    if (asked_ == 's') ::usleep(1500);
    log(!wrench.force.isZero(0.0));
  }
  void stop() noexcept override {
    stopped_ = true;
    log(false);
  }

 private:
  static int recur(int depth) {
    volatile char used[1024] = {};  // no loop does for it
    used[depth % 1024] = 1;
    return depth < 0 ? 0 : recur(depth + 1) + used[0];
  }
  void log(bool pulls) noexcept { (void)!::pwrite(file_, pulls ? "1" : "0", 1, 0); }

  palpate::DeviceCapabilities capabilities_;
  int file_;
  double first_ = -1.0, last_ = 0.0;
  char asked_ = 0;
  std::atomic<bool> stopped_ = false;
};

std::unique_ptr<palpate::HapticDevice> make(const std::string& path) {
  return std::make_unique<LoggedMotors>(path);
}

}  // namespace

const PalpateDevicePlugin* palpate_device_plugin(uint32_t) { return &palpate::ExportedDevice<make>::kPlugin; }

/// \file
/// A CrtkDevice and the other end of its network, without one.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <palpate/base/clock.h>
#include <palpate/gateway/crtk_device.h>

namespace palpate::test {

inline constexpr double kMilli = 1e-3;
inline constexpr double kOffset = 5000.0;  // of the driver's clock, s

/// The other end, without a network.
class CrtkPeer final : public CrtkTransport {
 public:
  void start(CrtkDevice& device) override { device_ = &device; }
  void stop() noexcept override {}
  void send(const CrtkWrench& wrench, const std::string& frame) override {
    const std::scoped_lock lock(mutex_);
    last_ = wrench;
    frame_ = frame;
    ++sent_;
  }
  bool has_listener() override { return listens; }
  std::uint64_t arrivals() override { return came; }
  bool wants_local_model() override { return wants; }
  void send_local_model(const LocalModel& model, double stamp) override {
    const std::scoped_lock lock(mutex_);
    models_.emplace_back(model, stamp);
  }
  void send_echo(std::uint64_t number) override {
    const std::scoped_lock lock(mutex_);
    echo_ = number;
  }
  void say(const std::string& line) override {
    const std::scoped_lock lock(mutex_);
    said_.push_back(line);
  }

  CrtkWrench last() const {
    const std::scoped_lock lock(mutex_);
    return last_;
  }
  std::string frame() const {
    const std::scoped_lock lock(mutex_);
    return frame_;
  }
  std::uint64_t echo() const {
    const std::scoped_lock lock(mutex_);
    return echo_;
  }
  std::uint64_t sent() const {
    const std::scoped_lock lock(mutex_);
    return sent_;
  }

  std::vector<std::pair<LocalModel, double>> models() const {
    const std::scoped_lock lock(mutex_);
    return models_;
  }

  std::vector<std::string> said() const {
    const std::scoped_lock lock(mutex_);
    return said_;
  }

  std::atomic<bool> wants = false;
  std::atomic<bool> listens = true;  ///< to wrenches
  std::atomic<std::uint64_t> came = 1;

 private:
  CrtkDevice* device_ = nullptr;
  mutable std::mutex mutex_;
  CrtkWrench last_;
  std::string frame_;
  std::vector<std::pair<LocalModel, double>> models_;
  std::vector<std::string> said_;
  std::uint64_t echo_ = 0, sent_ = 0;
};

inline CrtkOptions crtk_options() {
  CrtkOptions o;
  o.capabilities.name = "omni";
  o.capabilities.force_max = 8.0;
  return o;
}

inline double driver_now() { return monotonic_now() + kOffset; }

/// A device that is enabled, and its peer.
struct CrtkLink {
  explicit CrtkLink(const CrtkOptions& with = crtk_options()) {
    auto made = std::make_unique<CrtkPeer>();
    peer = made.get();
    device = std::make_unique<CrtkDevice>(with, std::move(made));
    open_device(*device, {});
    device->enable();
  }
  /// A tick a millisecond after the last. \returns whether it read something.
  bool tick() {
    clock.sleep_until(clock.now() + kMilli);
    return device->read(clock.now(), reading);
  }
  void pose(double x, double age = 0.0, const char* frame = "base", const char* source = "/arm") const {
    Pose p;
    p.position.x() = x;
    pose(p, driver_now() - age, frame, source);
  }
  void pose(const Pose& p, double stamp, const char* frame = "base", const char* source = "/arm") const {
    device->take_pose({stamp, frame, source}, p);
  }
  void ticks(int count, double x) {
    for (int k = 0; k < count; ++k) {
      pose(x);
      tick();
    }
  }

  CrtkPeer* peer = nullptr;
  std::unique_ptr<CrtkDevice> device;
  LoopClock clock;
  DeviceReading reading;
};

}  // namespace palpate::test

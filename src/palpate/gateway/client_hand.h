/// \file
/// Haptic device at the far end of a network connection.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include <palpate/base/triple_buffer.h>
#include <palpate/rosbridge/wake.h>
#include <palpate/servo/haptic_device.h>

namespace palpate {

/// Passes the poses of a client's hand from the gateway thread to the servo thread.
class ClientHand {
 public:
  struct Sample {
    DevicePose pose;           ///< X_DH
    double t = 0.0;            ///< estimated time of measurement, on the loop's clock. Unit: [s].
    std::uint64_t number = 0;  ///< from 1
    std::uint32_t hand = 0;    ///< changes with the hand
  };

  /// \name The gateway thread
  /// @{
  /// Publishes a pose. \param pose X_DH \returns its number.
  std::uint64_t put(const DevicePose& pose, double t);
  /// Marks later poses as those of another hand.
  void change_hand() { ++hand_; }
  /// Marks the hand as not held.
  void let_go() { held_.store(false, std::memory_order_relaxed); }
  /// @}

  /// \name The servo thread
  /// @{
  /// Returns the newest sample; the same one until another arrives.
  const Sample& newest();
  /// Waits until a pose is put, at most `seconds`.
  void wait(double seconds) { arrived_.wait(seconds); }
  /// @}

  /// Returns whether a client holds the hand. Any thread.
  bool is_held() const { return held_.load(std::memory_order_relaxed); }
  /// Returns the number of the sample that the servo thread read last. Any thread.
  std::uint64_t seen() const { return seen_.load(std::memory_order_acquire); }

 private:
  TripleBuffer<Sample> samples_;
  std::uint64_t count_ = 0;
  std::uint32_t hand_ = 0;
  std::atomic<std::uint64_t> seen_ = 0;
  std::atomic<bool> held_ = false;
  Wake arrived_;
};

/// Haptic device that is a network client: its poses are the readings, and the wrenches of the ticks are sent
/// back to it. A new reading ends the wait for the next tick.
class ClientDevice final : public HapticDevice {
 public:
  /// `hand` must outlive it. \param capabilities whose rate is the minimum rate of the client's poses
  ClientDevice(DeviceCapabilities capabilities, ClientHand& hand)
      : capabilities_(std::move(capabilities)), hand_(hand) {}

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double t, DeviceReading& reading) override;
  void write(const Wrench&) override {}
  void wait(const LoopClock& clock, double until) override;

  /// Time constant of the velocity filter, for poses whose arrival times jitter. Unit: [s].
  static constexpr double kVelocityFilter = 5e-3;
  /// Minimum time between two ticks, however fast a client sends. Unit: [s].
  static constexpr double kLeastPeriod = 2.5e-4;

 private:
  DeviceCapabilities capabilities_;
  ClientHand& hand_;
  std::uint64_t read_ = 0;  ///< number of the sample that was read last
  DeviceReading last_;
  double ticked_ = 0.0;  ///< Unit: [s].
};

}  // namespace palpate

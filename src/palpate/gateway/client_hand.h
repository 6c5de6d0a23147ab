/// \file
/// A hand at the other end of a network.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include <palpate/base/triple_buffer.h>
#include <palpate/rosbridge/wake.h>
#include <palpate/servo/haptic_device.h>

namespace palpate {

/// Where a client's hand is, on its way from the gateway's thread to the servo's.
class ClientHand {
 public:
  struct Sample {
    DevicePose pose;           ///< X_DH
    double t = 0.0;            ///< when it was measured, as far as is known, on the loop's clock. Unit: [s].
    std::uint64_t number = 0;  ///< from 1
    std::uint32_t hand = 0;    ///< another number: another hand
  };

  /// \name The gateway's thread
  /// @{
  /// \param pose X_DH \returns its number.
  std::uint64_t put(const DevicePose& pose, double t);
  /// What is put from now on is where another hand is.
  void change_hand() { ++hand_; }
  /// Nobody holds on any longer.
  void let_go() { held_.store(false, std::memory_order_relaxed); }
  /// @}

  /// \name The servo thread
  /// @{
  /// The newest; the same one until another has come.
  const Sample& newest();
  /// Waits until something is put, for `seconds` at most.
  void wait(double seconds) { arrived_.wait(seconds); }
  /// @}

  /// Whether somebody holds on. Any thread.
  bool is_held() const { return held_.load(std::memory_order_relaxed); }
  /// Number of the sample that the servo thread has seen last. Any thread.
  std::uint64_t seen() const { return seen_.load(std::memory_order_acquire); }

 private:
  TripleBuffer<Sample> samples_;
  std::uint64_t count_ = 0;
  std::uint32_t hand_ = 0;
  std::atomic<std::uint64_t> seen_ = 0;
  std::atomic<bool> held_ = false;
  Wake arrived_;
};

/// A device that is a client: its poses are readings, and the wrenches go back as what a tick has sent. A
/// reading ends the wait for the next tick.
class ClientDevice final : public HapticDevice {
 public:
  /// `hand` must outlive it. \param capabilities whose rate says how often the client sends at least
  ClientDevice(DeviceCapabilities capabilities, ClientHand& hand)
      : capabilities_(std::move(capabilities)), hand_(hand) {}

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double t, DeviceReading& reading) override;
  void write(const Wrench&) override {}
  void wait(const LoopClock& clock, double until) override;

  /// Of a velocity, from poses whose times of arrival jitter. Unit: [s].
  static constexpr double kVelocityFilter = 5e-3;
  /// Between two ticks at least, however fast a client sends. Unit: [s].
  static constexpr double kLeastPeriod = 2.5e-4;

 private:
  DeviceCapabilities capabilities_;
  ClientHand& hand_;
  std::uint64_t read_ = 0;  ///< number of the sample that was read last
  DeviceReading last_;
  double ticked_ = 0.0;  ///< Unit: [s].
};

}  // namespace palpate

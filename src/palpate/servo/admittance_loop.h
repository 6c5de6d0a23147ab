/// \file
/// A device of the admittance type behind the interface of one that takes wrenches.
#pragma once

#include <memory>
#include <optional>

#include <palpate/base/triple_buffer.h>
#include <palpate/servo/admittance_controller.h>
#include <palpate/servo/haptic_device.h>
#include <palpate/servo/least_admittance.h>
#include <palpate/servo/motion_governor.h>

namespace palpate {

/// How an AdmittanceLoop is set up.
struct AdmittanceLoopOptions {
  Admittance admittance;
  MotionLimits limits;
  double period = 1e-3;  ///< between calls of write(). Unit: [s]. > 0
  /// Along each axis, and about each: what the loop is taken to be. `delay` without the half tick.
  AdmittanceLoopModel along, about;
  /// What admittance must have of gain margin; 0: it is not checked, for trials in virtual time.
  double margin = kDesignMargin;
  std::optional<MotionSafety> safety;  ///< in place of MotionSafety::of() the device
};

/// A MotionDevice as a HapticDevice, so that ServoTick and all that looks on see one like any other. What is
/// written is the setpoint F_scene of the paper's section IV; with the hand's force it becomes an
/// acceleration:
///
///     MotionDevice::read -> MotionGovernor::admit -> [ServoTick: model, passivity, SafetyGovernor] -> write:
///         AdmittanceController -> MotionDevice::move -> MotionGovernor::moved
///
/// Readings are measured ones, so the energy that PassivityController observes is that of the scene's force
/// on the way that the handle really goes. capabilities() tell the virtual damping as the device's own, and
/// as delay all that is between force and motion: ServoTick lowers stiffnesses that are not passive with
/// these.
///
/// Where the device cannot follow, the controller's motion is put to what it does instead: nothing is wound
/// up, and nothing jumps when it is free again. status_text() then tells what holds it.
///
/// While MotionGovernor brakes for a fault, read() has nothing, and the status is DeviceStatus::kFault.
class AdmittanceLoop final : public HapticDevice {
 public:
  /// \param device must outlive it. \throws Error, which names the axis and the bound, if the admittance is
  /// not stable with the loop's margin.
  AdmittanceLoop(MotionDevice& device, const AdmittanceLoopOptions& options);
  /// The same, with a device of its own.
  AdmittanceLoop(std::unique_ptr<MotionDevice> device, const AdmittanceLoopOptions& options);

  /// \throws Error as the constructor: an admittance that is not stable in `options`.
  static void check(const AdmittanceLoopOptions& options);

  void open() override;
  void enable() override;
  void close() noexcept override;
  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double t, DeviceReading& reading) override;
  void write(const Wrench& wrench) override;
  void wait(const LoopClock& clock, double until) override { device_.wait(clock, until); }
  void stop() noexcept override;

  /// Another admittance, and the stiffest contact from now on; M and D go there as AdmittanceController says.
  /// From one thread besides the loop's. \throws Error as the constructor; nothing is then changed.
  void change(const Admittance& admittance, double contact_stiffness);

  /// For stop(), resume() and tare() from any thread; else of the loop's.
  MotionGovernor& governor() { return governor_; }
  const MotionGovernor& governor() const { return governor_; }

  /// \name On the loop's thread
  /// @{
  /// What the hand exerts on the handle, without the sensor's bias. Device's frame.
  Wrench user() const { return governor_.user(); }
  /// The controller's, which the device is told.
  const MotionSetpoint& motion() const { return controller_.motion(); }
  const MotionAnswer& answer() const { return answer_; }  ///< the device's, to that
  /// What has held the device in the last kToldFor, for a person; empty where nothing has. Against a limit
  /// the controller's motion goes a little beyond, and is put back, many times a second.
  const char* held_by() const { return held_ && t_ - held_at_ < kToldFor ? held_reason_ : ""; }
  static constexpr double kToldFor = 0.25;  ///< Unit: [s].
  const Admittance& admittance() const { return controller_.admittance(); }
  /// @}

 private:
  void tell_status() noexcept;
  static DeviceCapabilities told(const MotionDevice& device, const AdmittanceLoopOptions& options);

  std::unique_ptr<MotionDevice> owned_;  ///< null where it is another's
  MotionDevice& device_;
  AdmittanceLoopOptions options_;  ///< of the thread that calls change()
  const double period_;            ///< Unit: [s].
  DeviceCapabilities capabilities_;
  MotionGovernor governor_;
  AdmittanceController controller_;
  TripleBuffer<Admittance> next_;
  MotionReading said_;
  bool heard_ = false, started_ = false;
  double t_ = 0.0, written_at_ = 0.0;  ///< Unit: [s].
  MotionAnswer answer_;
  bool held_ = false;
  double held_at_ = 0.0;  ///< Unit: [s].
  const char* held_reason_ = "";
};

}  // namespace palpate

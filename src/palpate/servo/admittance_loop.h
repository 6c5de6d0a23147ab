/// \file
/// Adapter of an admittance-type device to the impedance-type HapticDevice interface.
#pragma once

#include <memory>
#include <optional>

#include <palpate/base/triple_buffer.h>
#include <palpate/servo/admittance_controller.h>
#include <palpate/servo/haptic_device.h>
#include <palpate/servo/least_admittance.h>
#include <palpate/servo/motion_governor.h>

namespace palpate {

/// Options of an AdmittanceLoop.
struct AdmittanceLoopOptions {
  Admittance admittance;
  MotionLimits limits;
  double period = 1e-3;  ///< between calls of write(). Unit: [s]. > 0
  /// Loop model along each axis and about each axis. `delay` excludes the half tick.
  AdmittanceLoopModel along, about;
  /// Required gain margin of the admittance; 0 = not checked, for trials in virtual time.
  double margin = kDesignMargin;
  std::optional<MotionSafety> safety;  ///< overrides MotionSafety::of() of the device
};

/// Presents a MotionDevice as a HapticDevice, so that ServoTick and all observers treat it like any other.
/// The written wrench is the setpoint F_scene of the paper's section IV; with the hand's force it gives an
/// acceleration:
///
///     MotionDevice::read -> MotionGovernor::admit -> [ServoTick: model, passivity, SafetyGovernor] -> write:
///         AdmittanceController -> MotionDevice::move -> MotionGovernor::moved
///
/// Readings are measured, so PassivityController observes the work of the scene's force along the actual
/// motion of the handle. capabilities() reports the virtual damping as the device's own and, as delay, the
/// whole delay from force to motion; ServoTick lowers stiffnesses that are not passive with these.
///
/// Where the device cannot follow, the controller's motion is reset to the device's actual motion: there is
/// no windup, and no jump when the device is free again. status_text() then names the cause.
///
/// While MotionGovernor brakes for a fault, read() returns false and the status is DeviceStatus::kFault. A
/// loop that ends brakes first (come_to_rest()); close() stops a handle that moves all the same.
///
/// The first setpoint is the pose of the first valid reading. A handle that comes back elsewhere after
/// invalid readings, or with another hand, is told to stop and gets no setpoint until its readings are
/// consistent again; the motion then starts where it is.
class AdmittanceLoop final : public HapticDevice {
 public:
  /// \param device must outlive this object. \throws Error, which names the axis and the bound, if the
  /// admittance is not stable with the required margin.
  AdmittanceLoop(MotionDevice& device, const AdmittanceLoopOptions& options);
  /// Takes ownership of the device.
  AdmittanceLoop(std::unique_ptr<MotionDevice> device, const AdmittanceLoopOptions& options);

  /// Checks the stability of the admittance in `options`. \throws Error as the constructor.
  static void check(const AdmittanceLoopOptions& options);

  void open() override;
  void enable() override;
  void close() noexcept override;
  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double t, DeviceReading& reading) override;
  void write(const Wrench& wrench) override;
  /// Brakes for Fault::kEnded. True at rest, and after MotionLimits::stop_time(): a device that holds the
  /// motion back for longer is then told to stop. In another loop, MotionGovernor::resume() lets it move
  /// again.
  bool come_to_rest() override;
  void wait(const LoopClock& clock, double until) override { device_.wait(clock, until); }
  void stop() noexcept override;

  /// Sets another admittance and the stiffest contact from now on; M and D change gradually
  /// (AdmittanceController). Damping below that of capabilities() is raised to it: the loop counts on that.
  /// Called by one thread besides the loop's. \throws Error as the constructor;
  /// nothing is then changed.
  void change(const Admittance& admittance, double contact_stiffness);

  /// stop(), resume() and tare() may be called from any thread; all else from the loop's thread.
  MotionGovernor& governor() { return governor_; }
  const MotionGovernor& governor() const { return governor_; }

  /// \name On the loop's thread
  /// @{
  /// Wrench of the hand on the handle, sensor bias removed. Device's frame.
  Wrench user() const { return governor_.user(); }
  /// The controller's setpoint, as sent to the device.
  const MotionSetpoint& motion() const { return controller_.motion(); }
  const MotionAnswer& answer() const { return answer_; }  ///< the device's answer to that setpoint
  /// Reason, readable by a person, why the device was held back within the last kToldFor; empty if it was
  /// not. At a limit the controller's motion overshoots slightly and is reset many times a second.
  const char* held_by() const { return held_ && t_ - held_at_ < kToldFor ? held_reason_ : ""; }
  static constexpr double kToldFor = 0.25;  ///< Unit: [s].
  const Admittance& admittance() const { return controller_.admittance(); }
  /// @}

 private:
  void tell_status() noexcept;
  static DeviceCapabilities told(const MotionDevice& device, const AdmittanceLoopOptions& options);

  std::unique_ptr<MotionDevice> owned_;  ///< null if the device is not owned
  MotionDevice& device_;
  AdmittanceLoopOptions options_;  ///< used by the thread that calls change()
  const double period_;            ///< Unit: [s].
  DeviceCapabilities capabilities_;
  MotionGovernor governor_;
  AdmittanceController controller_;
  TripleBuffer<Admittance> next_;
  MotionReading said_;
  bool heard_ = false, started_ = false;
  double t_ = 0.0, written_at_ = 0.0;  ///< Unit: [s].
  std::optional<double> rests_by_;     ///< when it should be at rest, if the loop is to end. Unit: [s].
  MotionAnswer answer_;
  bool held_ = false;
  double held_at_ = 0.0;  ///< Unit: [s].
  const char* held_reason_ = "";
};

}  // namespace palpate

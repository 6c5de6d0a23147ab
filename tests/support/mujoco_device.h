/// \file
/// A device and the hand that holds it, moved by MuJoCo: what SimulatedDevice is compared with.
#pragma once

#include <deque>
#include <memory>

#include <mujoco/mujoco.h>

#include <palpate/device/simulated_device.h>

namespace palpate::test {

/// The handle is a body on three slide joints along the axes of the world, and on a ball joint where the
/// device has torque motors; elsewhere it is turned as the hand is. Viscous friction is the joints' damping,
/// dry friction their frictionloss: that of each axis by itself, so that it is Coulomb's only for what moves
/// along one. There is no gravity, and no contact of MuJoCo's.
///
/// The integrator is Runge-Kutta of fourth order. A handle in a hand is not stiff (b / m and the square root
/// of k / m are a few hundred a second at most), so nothing asks for an implicit one; and those that MuJoCo
/// has are of first order, as SimulatedDevice is, so that the two would share the error which is looked for.
/// What the hand does is computed anew at each of the four stages. So a step of kStep errs by less than 1e-10
/// m where the friction is viscous (a test says so); dry friction, which stops between steps, by some 1e-8 m.
///
/// A reading tells pose and velocity as SimulatedDevice does, in steps of the encoders if the plant has them,
/// and the velocity from differences through a low-pass filter: force models damp with that velocity, and
/// with another filter this would be another loop.
///
/// Takes memory in write(), which a driver must not. One thread at a time moves devices.
class MujocoDevice final : public HapticDevice {
 public:
  /// \param step the longest of the integration. Unit: [s]. \throws std::runtime_error if MuJoCo does not
  /// take the model.
  MujocoDevice(const DeviceCapabilities& capabilities, const PlantProperties& plant,
               const HandProperties& hand, HandPath path, double step = kStep);

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  /// \throws std::runtime_error where MuJoCo's state is no longer finite.
  bool read(double t, DeviceReading& reading) override;
  void write(const Wrench& wrench) override;

  /// Where the handle really is. World frame.
  Pose pose() const;
  Twist velocity() const;

  static constexpr double kStep = 2e-4;  ///< Unit: [s].

 private:
  struct Due {
    double t = 0.0;  ///< from when on the motors show it. Unit: [s].
    Wrench wrench;
  };
  struct Deleter {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
    void operator()(mjData* data) const { mj_deleteData(data); }
  };

  void start(double t);
  void advance(double until);
  Twist hand_velocity(double t) const;
  void apply_wrench() const;
  Pose encoded() const;
  void tell(double t);

  DeviceCapabilities capabilities_;
  PlantProperties plant_;
  HandProperties hand_;
  HandPath path_;
  double step_;
  bool turns_;  ///< has torque motors
  std::unique_ptr<mjModel, Deleter> model_;
  std::unique_ptr<mjData, Deleter> data_;
  std::deque<Due> due_;
  Wrench shown_;
  bool started_ = false;
  DeviceReading told_;
};

}  // namespace palpate::test

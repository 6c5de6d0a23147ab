// A hand that holds a device that feels a scene: all of it, in virtual time.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/scene_index.h>
#include <palpate/device/profiles.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/servo/servo_tick.h>
#include <palpate/study/procedural.h>
#include <support/allocation_guard.h>
#include <support/force_models.h>
#include <support/noisy_plane.h>
#include <support/tick.h>
#include <support/uneven_ticks.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::kTick;

constexpr double kRadius = 0.02;

const Tool& tool() {
  static const Tool ball{Vector3d::Constant(kRadius)};
  return ball;
}

/// Waits above the plane until the force is on, comes down in half a second, and presses as deep as `depth`;
/// from `slides` on it moves along the plane at 0.1 m/s.
HandPath press(double depth, double slides = std::numeric_limits<double>::infinity()) {
  return [=](double t) {
    const double down = std::clamp((t - 0.8) / 0.5, 0.0, 1.0);
    Pose pose;
    pose.position.z() = kRadius + 0.01 - (0.01 + depth) * down * down * (3.0 - 2.0 * down);
    pose.position.x() = t > slides ? 0.1 * (t - slides) : 0.0;
    return pose;
  };
}

struct Trial {
  std::string profile, model;
  HandProperties hand;
};

void PrintTo(const Trial& trial, std::ostream* out) {
  *out << trial.profile << ", " << trial.model << ", hand of " << trial.hand.mass << " kg, "
       << trial.hand.damping << " N s/m, " << trial.hand.stiffness << " N/m";
}

class ClosedLoop : public testing::TestWithParam<Trial> {
 protected:
  void SetUp() override {
    const DeviceProfile& profile = device_profile(GetParam().profile);
    model_ = test::model_called(GetParam().model, test::noisy_plane(), tool());
    tracker_ = std::make_unique<ToolTracker>(test::noisy_plane(), tool());
    capabilities_ = profile.capabilities;
    capabilities_.force_sustained = 0.0;  // the way down to it is a motion, and no instability
    plant_ = profile.plant;
  }
  void hold(HandPath path) {
    device_ = std::make_unique<SimulatedDevice>(capabilities_, plant_, GetParam().hand, std::move(path));
    loop_ = std::make_unique<ServoTick>(*device_, FeltModel{model_.get(), tracker_.get()});
  }
  const TickRecord& tick() { return loop_->run(kTick * static_cast<double>(count_++)); }
  /// Presses on uneven ticks, with a force that is late by `delay`, and half of the damping that the device
  /// is said to have, of which the controller knows nothing. \returns the least margin
  double expect_rest_on_uneven_ticks(double delay);

  DeviceCapabilities capabilities_;
  PlantProperties plant_;
  std::unique_ptr<ForceModel> model_;
  std::unique_ptr<ToolTracker> tracker_;
  std::unique_ptr<SimulatedDevice> device_;
  std::unique_ptr<ServoTick> loop_;
  int count_ = 0;
};

TEST_P(ClosedLoop, RestsOnTheSurface) {
  hold(press(0.01));
  while (count_ < 2500) tick();
  Eigen::AlignedBox3d rest(device_->pose().position);
  while (count_ < 3500) {
    tick();
    rest.extend(device_->pose().position);
  }
  EXPECT_EQ(loop_->governor().state(), GovernorState::kActive) << traits(loop_->governor().fault()).name;
  EXPECT_LE(rest.diagonal().norm(), 0.05e-3);
  EXPECT_LE(tick().port_energy, 1e-3);
  EXPECT_LT(device_->pose().position.z(), kRadius);  // it presses
  EXPECT_GT(device_->pose().position.z(), kRadius - 0.01);
}

TEST_P(ClosedLoop, MakesNoEnergyWhileSliding) {
  hold(press(0.01, 2.0));
  while (count_ < 3500) tick();
  EXPECT_EQ(loop_->governor().state(), GovernorState::kActive) << traits(loop_->governor().fault()).name;
  EXPECT_LE(tick().port_energy, 1e-3);
}

double ClosedLoop::expect_rest_on_uneven_ticks(double delay) {
  capabilities_.damping = capabilities_.angular_damping = 0.0;
  plant_ = device_profile(GetParam().profile).plant;
  plant_.damping *= 0.5;
  plant_.delay = delay;
  hold(press(0.01, 5.5));
  loop_->set_delay(delay);
  test::UnevenTicks ticks;
  double t = 0.0, softest = std::numeric_limits<double>::infinity();
  Eigen::AlignedBox3d rest;
  const TickRecord* now = nullptr;
  while (t < 6.5) {
    t = ticks.next();
    now = &loop_->run(t);
    if (now->margin > 0.0) softest = std::min(softest, now->margin);
    if (t > 4.5 && t < 5.5) rest.extend(device_->pose().position);
  }
  EXPECT_EQ(now->state, GovernorState::kActive) << delay << ": " << traits(now->fault).name;
  EXPECT_LE(rest.diagonal().norm(), 0.05e-3) << delay << ", margin " << softest;
  EXPECT_LE(now->port_energy, 1e-3) << delay << ", margin " << softest;
  return softest;
}

// Either the hand rests or the stiffness is lowered until it does.
TEST_P(ClosedLoop, RestsHoweverLateAndUneven) {
  for (const double delay : {0.0, 1e-3, 3e-3, 10e-3}) {
    model_->reset();
    const double softest = expect_rest_on_uneven_ticks(delay);
    if (delay == 10e-3) {
      EXPECT_LT(softest, 1.0) << "500 N/m at 10 ms are not passive";
    }
  }
}

class ClosedLoopOfMaterials : public ClosedLoop {};

// With all the damping that the device can render.
TEST_P(ClosedLoopOfMaterials, RestsOnADampedMaterialHoweverLate) {
  ProxyParameters parameters;
  Material material;
  material.damping = 1e3;
  parameters.materials =
      std::make_shared<MaterialMap>(std::vector<MaterialRegion>{{MaterialRegion::Everywhere{}, material}});
  for (const double delay : {0.0, 1e-3, 3e-3, 10e-3}) {
    model_ = std::make_unique<ProxyForce>(test::noisy_plane(), tool(), parameters);
    expect_rest_on_uneven_ticks(delay);
  }
}

TEST_P(ClosedLoop, TakesNothingFromTheHeap) {
  hold(press(0.01, 1.5));
  const test::AllocationGuard guard;
  while (count_ < 2000) tick();
  EXPECT_EQ(guard.count(), 0U);
}

std::vector<Trial> trials(const std::vector<const char*>& models) {
  std::vector<Trial> all;
  const std::vector<HandProperties> hands{{0.05, 1.0, 100.0}, {0.15, 3.0, 400.0}, {0.3, 10.0, 1000.0}};
  for (const DeviceProfile& profile : device_profiles())
    for (const char* model : models)
      for (const HandProperties& hand : hands) all.push_back({profile.capabilities.name, model, hand});
  return all;
}

INSTANTIATE_TEST_SUITE_P(AllDevices, ClosedLoop, testing::ValuesIn(trials({"field", "proxy"})));
INSTANTIATE_TEST_SUITE_P(AllDevices, ClosedLoopOfMaterials, testing::ValuesIn(trials({"proxy"})));

}  // namespace
}  // namespace palpate

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
#include <palpate/haptics/field_force.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/scene/procedural.h>
#include <palpate/servo/servo_tick.h>
#include <support/allocation_guard.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kTick = 1e-3, kRadius = 0.02;

/// A plane at z = 0, noisy as captures are, and the models that feel it.
class Scene {
 public:
  Scene() {
    const auto surface = make_surface("plane");
    ProceduralOptions options;
    options.spacing = 0.006;
    options.noise = 0.0015;
    options.tilt = 10.0 * std::numbers::pi / 180.0;
    index_ = std::make_unique<SceneIndex>(make_scene(*surface, options), SceneFilter{}, Similarity{});
  }
  std::unique_ptr<ForceModel> model(const std::string& name) const {
    if (name == "field") return std::make_unique<FieldForce>(tool);
    return std::make_unique<ProxyForce>(*index_, tool);
  }
  const SceneIndex& index() const { return *index_; }

  Tool tool{Vector3d::Constant(kRadius)};

 private:
  std::unique_ptr<SceneIndex> index_;
};

const Scene& scene() {
  static const Scene made;
  return made;
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
    model_ = scene().model(GetParam().model);
    tracker_ = std::make_unique<ToolTracker>(scene().index(), scene().tool);
    capabilities_ = profile.capabilities;
    plant_ = profile.plant;
  }
  void hold(HandPath path) {
    device_ = std::make_unique<SimulatedDevice>(capabilities_, plant_, GetParam().hand, std::move(path));
    loop_ = std::make_unique<ServoTick>(*device_, FeltModel{model_.get(), tracker_.get()});
  }
  const TickRecord& tick() { return loop_->run(kTick * static_cast<double>(count_++)); }

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
  Vector3d low = device_->pose().position, high = low;
  while (count_ < 3500) {
    tick();
    low = low.cwiseMin(device_->pose().position);
    high = high.cwiseMax(device_->pose().position);
  }
  EXPECT_EQ(loop_->governor().state(), GovernorState::kActive) << traits(loop_->governor().fault()).name;
  EXPECT_LE((high - low).norm(), 0.05e-3);
  EXPECT_LE(tick().put_out, 1e-3);
  EXPECT_LT(device_->pose().position.z(), kRadius);  // it presses
  EXPECT_GT(device_->pose().position.z(), kRadius - 0.01);
}

TEST_P(ClosedLoop, MakesNoEnergyWhileSliding) {
  hold(press(0.01, 2.0));
  while (count_ < 3500) tick();
  EXPECT_EQ(loop_->governor().state(), GovernorState::kActive) << traits(loop_->governor().fault()).name;
  EXPECT_LE(tick().put_out, 1e-3);
}

TEST_P(ClosedLoop, TakesNothingFromTheHeap) {
  hold(press(0.01, 1.5));
  const test::AllocationGuard guard;
  while (count_ < 2000) tick();
  EXPECT_EQ(guard.count(), 0U);
}

std::vector<Trial> trials() {
  std::vector<Trial> all;
  const std::vector<HandProperties> hands{{0.05, 1.0, 100.0}, {0.15, 3.0, 400.0}, {0.3, 10.0, 1000.0}};
  for (const DeviceProfile& profile : device_profiles())
    for (const char* model : {"field", "proxy"})
      for (const HandProperties& hand : hands) all.push_back({profile.capabilities.name, model, hand});
  return all;
}

INSTANTIATE_TEST_SUITE_P(AllDevices, ClosedLoop, testing::ValuesIn(trials()));

}  // namespace
}  // namespace palpate

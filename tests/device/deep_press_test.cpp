// A hand that pushes far past the largest force of its device, and comes back: no fault, whether ticks come
// evenly or not.
#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include <palpate/collision/scene_index.h>
#include <palpate/device/profiles.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/servo/servo_tick.h>
#include <palpate/study/procedural.h>
#include <support/tick.h>
#include <support/uneven_ticks.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::kTick;

constexpr double kSpeed = 0.1;
const Vector3d kTool(0.02, 0.02, 0.04);  // the default one

/// What is pressed from above, and how deep. Unit: [m].
struct Thing {
  explicit Thing(const std::string& surface, double height, double pressed)
      : index(make_scene(*make_surface(surface), ProceduralOptions{}), SceneFilter{}, Similarity{}),
        top(height),
        depth(pressed) {}
  SceneIndex index;
  double top, depth;
};

/// The last is much deeper than the handle of a device goes, as a simulated one does that a mouse leads.
const std::array<Thing, 3>& things() {
  static const std::array<Thing, 3> all{Thing("sphere", 0.15, 0.12), Thing("sphere", 0.15, 0.16),
                                        Thing("plane", 0.0, 0.35)};
  return all;
}

/// From 3 cm above a thing down into it, and back.
struct Press {
  static constexpr double kAbove = 0.03, kBegins = 0.8, kRests = 0.3;
  double top, depth;

  double way() const { return (kAbove + depth) / kSpeed; }  // Unit: [s].
  double seconds() const { return kBegins + 2.0 * way() + kRests + 0.5; }
  Pose at(double t) const {
    const double down = std::min(t - kBegins, kBegins + 2.0 * way() + kRests - t);
    Pose pose;
    pose.position.z() = top + kTool.z() + kAbove - kSpeed * std::clamp(down, 0.0, way());
    return pose;
  }
};

/// When the next tick is, given when the last one was. Unit: [s].
using Clock = std::function<double(double)>;

/// Ticks like clockwork, but for one that is `late` of each `every`. Unit: [s].
Clock with_late_ones(double late, double every) {
  return [=, count = 0](double t) mutable {
    return ++count % static_cast<int>(every / kTick) == 0 ? t + late : t + kTick;
  };
}

struct NamedClock {
  std::string name;
  std::function<Clock()> clock;
};

void PrintTo(const NamedClock& named, std::ostream* out) { *out << named.name; }

class DeepPress : public testing::TestWithParam<NamedClock> {};

TEST_P(DeepPress, IsNoFault) {
  const DeviceProfile& omega = device_profile("omega");
  for (const auto& [index, top, depth] : things()) {
    const Tool tool{kTool};
    ProxyForce model(index, tool);
    ToolTracker tracker(index, tool);
    const Press press{top, depth};
    SimulatedDevice device(omega.capabilities, omega.plant, HandProperties{},
                           [press](double t) { return press.at(t); });
    ServoTick loop(device, FeltModel{&model, &tracker});
    const Clock next = GetParam().clock();
    double t = 0.0, most = 0.0;
    while (t < press.seconds()) {
      const TickRecord& now = loop.run(t);
      most = std::max(most, now.sent_world.force.norm());
      ASSERT_EQ(now.fault, Fault::kNone) << depth << " m, after " << t << " s: " << traits(now.fault).name;
      t = next(t);
    }
    EXPECT_EQ(loop.governor().state(), GovernorState::kActive);
    EXPECT_NEAR(most, omega.capabilities.force_max, 0.01) << depth;
  }
}

INSTANTIATE_TEST_SUITE_P(Clocks, DeepPress,
                         testing::Values(NamedClock{"Even", [] { return with_late_ones(kTick, 1.0); }},
                                         NamedClock{"Uneven",
                                                    [] {
                                                      return [ticks = test::UnevenTicks()](double) mutable {
                                                        return ticks.next();
                                                      };
                                                    }},
                                         // As late as the governor allows, again and again.
                                         NamedClock{"Late", [] { return with_late_ones(20e-3, 0.19); }}),
                         [](const auto& trial) { return trial.param.name; });

}  // namespace
}  // namespace palpate

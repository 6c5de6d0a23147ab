// The force at one pose: that of a tool that has rested there, whatever the model does at first.
#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/haptics/density_force.h>
#include <palpate/haptics/field_force.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/haptics/settled_force.h>
#include <palpate/haptics/tool_query.h>
#include <support/noisy_plane.h>

namespace palpate {
namespace {

/// Pushes up with a force that depends only on the number of the step since reset(), and turns with a torque
/// that does.
class ScriptedForce final : public ForceModel {
 public:
  using OfStep = std::function<double(int)>;
  explicit ScriptedForce(
      OfStep force, OfStep torque = [](int) { return 0.5; })
      : force_(std::move(force)), torque_(std::move(torque)) {}

  void reset() override { times.clear(); }
  ForceOutput evaluate(const ForceInput& input) override {
    times.push_back(input.dt);
    ForceOutput felt;
    const int step = static_cast<int>(times.size()) - 1;
    felt.wrench.force.z() = force_(step);
    felt.wrench.torque.x() = torque_(step);
    felt.is_known = step >= knows_after;
    return felt;
  }

  int knows_after = 0;        ///< steps
  std::vector<double> times;  ///< ForceInput::dt of each step

 private:
  OfStep force_, torque_;
};

Pose on_plane(double height) {
  Pose pose;
  pose.position.z() = height;
  return pose;
}

TEST(SettledForce, WaitsForAForceThatComesLate) {
  ScriptedForce model([](int step) { return step < 40 ? 0.0 : std::min(step - 40, 9) * 1e-3; });
  EXPECT_DOUBLE_EQ(settled_force(model, Pose{}, {}).wrench.force.z(), 9e-3);
  EXPECT_EQ(model.times.size(), 49U + 51U) << "the first step with the last force, and 50 more";
  EXPECT_EQ(model.times[0], 0.0);
  for (std::size_t k = 1; k < model.times.size(); ++k) EXPECT_EQ(model.times[k], 1e-3);
}

TEST(SettledForce, WaitsForATorqueThatComesLate) {
  ScriptedForce model([](int) { return 1.0; }, [](int step) { return step < 40 ? 0.0 : 0.2; });
  EXPECT_EQ(settled_force(model, Pose{}, {}).wrench.torque.x(), 0.2);
  EXPECT_EQ(model.times.size(), 40U + 51U);
}

// A tool of many parts takes many steps to know what it is in.
TEST(SettledForce, WaitsUntilTheModelKnows) {
  ScriptedForce model([](int step) { return step < 130 ? 0.0 : 3.0; }, [](int) { return 0.0; });
  model.knows_after = 130;
  EXPECT_EQ(settled_force(model, Pose{}, {}).wrench.force.z(), 3.0);
}

TEST(SettledForce, StartsAnewAndEndsWhereTheForceNeverSettles) {
  ScriptedForce model([](int step) { return 1.0 + 1e-3 * (step % 2); });
  model.times.assign(1000, 1.0);
  EXPECT_EQ(settled_force(model, Pose{}, {}).wrench.force.z(), 1.001);
  EXPECT_EQ(model.times.size(), 300U);
}

TEST(SettledForce, OfTheProxyIsThatOfALongRest) {
  const Tool ball(Eigen::Vector3d::Constant(0.02));
  for (const SceneIndex* scene : {&test::even_plane(), &test::noisy_plane()}) {
    ProxyForce model(*scene, ball);
    const Pose pose = on_plane(0.012);
    const Eigen::Vector3d settled = settled_force(model, pose, {}).wrench.force;
    EXPECT_GT(settled.z(), 1.0);
    ProxyForce other(*scene, ball);
    ForceOutput rested;
    for (int step = 0; step < 300; ++step) rested = other.evaluate({pose, {}, step == 0 ? 0.0 : 1e-3});
    EXPECT_LT((settled - rested.wrench.force).norm(), 1e-7);
  }
}

TEST(SettledForce, IsZeroInFreeSpace) {
  ProxyForce model(test::even_plane(), Tool(Eigen::Vector3d::Constant(0.02)));
  EXPECT_EQ(settled_force(model, on_plane(0.1), {}).wrench.force, Eigen::Vector3d::Zero());
}

TEST(SettledForce, OfModelsThatDoNotMoveIsTheirFirst) {
  const Tool tool;
  const Pose pose = on_plane(0.01);
  ContactSet contacts;
  query(test::noisy_plane(), tool, pose, contacts);
  ASSERT_FALSE(contacts.contacts.empty());
  DensityForce density(tool, {}), fresh(tool, {});
  FieldForce field(tool), fresh_field(tool);
  const auto equal = [&](ForceModel& one, ForceModel& other) {
    const Wrench first = other.evaluate({pose, {}, 0.0, &contacts}).wrench;
    EXPECT_GT(first.force.norm(), 0.1);
    const Wrench settled = settled_force(one, pose, contacts).wrench;
    EXPECT_LT((settled.force - first.force).norm() + (settled.torque - first.torque).norm(), 1e-12);
  };
  equal(density, fresh);
  equal(field, fresh_field);
}

}  // namespace
}  // namespace palpate

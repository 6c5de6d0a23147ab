// The yardstick itself: a model that knows the surface must come out perfect, and one that pulls in must not.

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/haptics/evaluation.h>
#include <palpate/haptics/proxy_force.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kRadius = 0.02, kStiffness = 800.0;

/// A spring, `sign` times out of the true surface, for a ball.
class Knowing final : public ForceModel {
 public:
  Knowing(const std::string& shape, double sign) : surface_(make_surface(shape)), sign_(sign) {}

  void reset() override {}
  ForceOutput evaluate(const ForceInput& input) override {
    const NearestPoint nearest = surface_->project(input.tool.position);
    const double depth = kRadius - nearest.distance;
    if (!(depth > 0.0)) return {Wrench{}, input.tool};
    Pose proxy = input.tool;
    if (sign_ > 0.0) proxy.position += depth * nearest.normal;
    return {{sign_ * kStiffness * depth * nearest.normal, Vector3d::Zero()}, proxy};
  }

 private:
  std::unique_ptr<AnalyticSurface> surface_;
  double sign_;
};

EvaluationSetup setup(const std::string& shape, double sign) {
  EvaluationSetup setup;
  setup.shape = shape;
  setup.scene.spacing = 0.01;
  setup.stiffness = kStiffness;
  setup.places = 10;
  setup.model = [=](const SceneIndex&) { return std::make_unique<Knowing>(shape, sign); };
  return setup;
}

class Yardstick : public testing::TestWithParam<const char*> {};

TEST_P(Yardstick, FindsNoFaultWithTheTruth) {
  const Evaluation e = evaluate(setup(GetParam(), 1.0));
  EXPECT_LE(e.direction.max, 1e-4);
  EXPECT_NEAR(e.magnitude.p05, 1.0, 1e-9);
  EXPECT_NEAR(e.magnitude.max, 1.0, 1e-9);
  EXPECT_EQ(e.silent, 0U);
  EXPECT_EQ(e.flipped, 0U);
  EXPECT_GE(e.onset.p05, 0.0);
  EXPECT_LE(e.onset.max, 1.01e-4);  // a tick's way
  EXPECT_LE(e.ripple.max, 1e-6);
  EXPECT_EQ(e.pushes, 10U);
  EXPECT_EQ(e.through, 0U);
  EXPECT_LE(e.loop.max, 1e-6);
}

TEST_P(Yardstick, SeesAForceThatPullsIn) {
  const Evaluation e = evaluate(setup(GetParam(), -1.0));
  EXPECT_NEAR(e.direction.p05, 180.0, 1e-3);
  EXPECT_GT(e.flipped, 1000U);
  EXPECT_EQ(e.through, e.pushes);
}

INSTANTIATE_TEST_SUITE_P(Shapes, Yardstick, testing::Values("sphere", "cylinder", "torus", "box"));

TEST(Evaluation, IsTheSameEveryTimeAndAnotherForAnotherSeed) {
  EvaluationSetup one = setup("sphere", 1.0);
  one.model = [](const SceneIndex& index) {
    return std::make_unique<ProxyForce>(index, Tool{Vector3d::Constant(kRadius)});
  };
  one.scene.noise = 0.001;
  const Evaluation first = evaluate(one), again = evaluate(one);
  EXPECT_EQ(first.direction.p50, again.direction.p50);
  EXPECT_EQ(first.jump.max, again.jump.max);
  one.seed = 2;
  EXPECT_NE(evaluate(one).direction.p50, first.direction.p50);
}

TEST(Evaluation, RefusesAToolThatFitsNowhere) {
  EvaluationSetup large = setup("torus", 1.0);
  large.tool = Tool{Vector3d::Constant(2.0)};
  EXPECT_THROW(evaluate(large), Error);
}

// A ball of 5 mm over a step of 3 mm that is sampled every 3 mm: what the default detail must leave of it.
TEST(StepResponse, AStepIsStillAStep) {
  ProceduralOptions scene;
  scene.spacing = 0.003;
  const Tool tool{Vector3d::Constant(0.005)};
  const StepResponse response = step_response(
      [&](const SceneIndex& index) { return std::make_unique<ProxyForce>(index, tool); }, tool, scene, 5, 1);
  EXPECT_EQ(response.height, 0.003);
  EXPECT_GE(response.felt.p05, 0.0024);
  EXPECT_LE(response.felt.max, 0.0036);
  EXPECT_LE(response.rise_over.max, 0.015);
}

}  // namespace
}  // namespace palpate

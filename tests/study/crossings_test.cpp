// Crossings of a step and an edge, with models that are right or wrong in a known way; and what the proxy
// must keep of a step.

#include <cmath>
#include <memory>
#include <numbers>

#include <gtest/gtest.h>

#include <palpate/haptics/proxy_force.h>
#include <palpate/study/crossings.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

/// A model that is a function from the tool's centre to the proxy's.
template <class Function>
class ProxyAt final : public ForceModel {
 public:
  explicit ProxyAt(Function function) : function_(function) {}
  void reset() override {}
  ForceOutput evaluate(const ForceInput& input) override {
    Pose proxy = input.tool;
    proxy.position = function_(input.tool.position);
    return {{proxy.position - input.tool.position, Vector3d::Zero()}, proxy};
  }

 private:
  Function function_;
};

template <class Function>
EvaluationSetup proxy_setup(Function function) {
  EvaluationSetup setup;
  setup.scene.spacing = 0.01;
  setup.places = 3;
  setup.model = [=](const SceneIndex&, const Tool&, double) {
    return std::make_unique<ProxyAt<Function>>(function);
  };
  return setup;
}

// Sides 3, 4 and 5: 3 mm before the step a ball of 5 mm on its edge is 4 mm above that.
TEST(StepTruth, IsABallThatRollsOverTheEdge) {
  EXPECT_DOUBLE_EQ(step_truth(-0.01), 0.005);
  EXPECT_DOUBLE_EQ(step_truth(-0.003), 0.007);
  EXPECT_DOUBLE_EQ(step_truth(0.0), 0.008);
  EXPECT_DOUBLE_EQ(step_truth(0.01), 0.008);
}

TEST(StepResponse, OfTheTruthIsTheStep) {
  const StepResponse response =
      step_response(proxy_setup([](const Vector3d& p) { return Vector3d(p.x(), p.y(), step_truth(p.x())); }));
  EXPECT_NEAR(response.felt.p05, 0.003, 1e-12);
  EXPECT_NEAR(response.felt.max, 0.003, 1e-12);
  // A tenth is risen where the ball's centre is 2.3 mm above the edge, nine tenths where 4.7 mm.
  const double from = std::sqrt(25.0 - 2.3 * 2.3), to = std::sqrt(25.0 - 4.7 * 4.7);
  EXPECT_NEAR(response.rise_over.p50, 1e-3 * (from - to), 1.5e-4);  // a tick and a half
  for (const CurvePoint& p : response.path) EXPECT_NEAR(p.value.p50, step_truth(p.at), 1.1e-3) << p.at;
}

TEST(StepResponse, OfARampIsWhatItRisesOnTheWay) {
  const StepResponse response =
      step_response(proxy_setup([](const Vector3d& p) { return Vector3d(p.x(), p.y(), 0.05 * p.x()); }));
  EXPECT_NEAR(response.felt.p50, 0.05 * 0.015, 1e-9);
  EXPECT_NEAR(response.rise_over.p50, 0.8 * 0.08, 3e-4);
}

// A ball of 5 mm over a step of 3 mm that is sampled every 3 mm: what the default detail must leave of it.
TEST(StepResponse, AStepIsStillAStep) {
  EvaluationSetup proxy;
  proxy.scene.spacing = 0.003;
  proxy.places = 5;
  proxy.model = [](const SceneIndex& index, const Tool& tool, double) {
    return std::make_unique<ProxyForce>(index, tool);
  };
  const StepResponse response = step_response(proxy);
  EXPECT_GE(response.felt.p05, 0.0024);
  EXPECT_LE(response.felt.max, 0.0036);
  EXPECT_LE(response.rise_over.max, 0.015);
}

constexpr double kBall = 0.02;

/// Where the centre of a ball is that rolls over the box, pressed on by a tool at `p`; on the turn about the
/// edge `sunk` deep.
Vector3d rolled(const Vector3d& p, double sunk) {
  static const auto box = make_surface("box");
  const NearestPoint nearest = box->project(p);
  const bool turns = p.x() > 0.15 && p.z() > 0.08;
  return nearest.point + (kBall - (turns ? sunk : 0.0)) * nearest.normal;
}

TEST(EdgeResponse, OfTheTruthIsNothing) {
  const EdgeResponse response = edge_response(proxy_setup([](const Vector3d& p) { return rolled(p, 0.0); }));
  EXPECT_LE(response.off.max, 1e-12);
  ASSERT_FALSE(response.error.empty());
  // The way is that of the ball's centre: a quarter turn at its radius, and 40 mm on either side.
  const double end = 0.25 * std::numbers::pi * kBall + 0.04;
  EXPECT_NEAR(response.error.front().at, -end, 2e-3);
  EXPECT_NEAR(response.error.back().at, end, 2e-3);
}

TEST(EdgeResponse, FindsWhereTheProxySinksIn) {
  const EdgeResponse response =
      edge_response(proxy_setup([](const Vector3d& p) { return rolled(p, 1.5e-3); }));
  EXPECT_NEAR(response.off.p05, 1.5e-3, 1e-9);
  EXPECT_LE(std::abs(response.where), 0.25 * std::numbers::pi * kBall);
  for (const CurvePoint& p : response.error) {
    if (std::abs(p.at) < 0.014) {
      EXPECT_NEAR(p.value.p50, -1.5e-3, 1e-9) << p.at;
    }
    if (std::abs(p.at) > 0.018) {
      EXPECT_NEAR(p.value.p50, 0.0, 1e-9) << p.at;
    }
  }
}

// Every crossing goes through the air at the hand's speed, and is of one of the scenes in turn.
TEST(Crossings, AreAsManyAsAreAskedForAndDoNotJump) {
  class Watching final : public ForceModel {
   public:
    Watching(std::vector<int>& crossings, double& jump) : crossings_(crossings), jump_(jump) {
      crossings_.push_back(0);
    }
    void reset() override {
      ++crossings_.back();
      moving_ = false;
    }
    ForceOutput evaluate(const ForceInput& input) override {
      if (moving_) jump_ = std::max(jump_, (input.tool.position - last_).norm());
      last_ = input.tool.position;
      moving_ = true;
      return {Wrench{}, input.tool};
    }

   private:
    std::vector<int>& crossings_;
    double& jump_;
    Vector3d last_;
    bool moving_ = false;
  };
  std::vector<int> crossings;
  double jump = 0.0;
  EvaluationSetup setup;
  setup.scene.spacing = 0.02;
  setup.places = 5;
  setup.scenes = 2;
  setup.model = [&](const SceneIndex&, const Tool&, double) {
    return std::make_unique<Watching>(crossings, jump);
  };
  step_response(setup);
  edge_response(setup);
  EXPECT_EQ(crossings, (std::vector<int>{3, 2, 3, 2}));
  EXPECT_LE(jump, 2.0 * 1e-4 + 1e-9);  // two ticks' way
}

// Half its radius deep all the way: 10 mm from the box.
TEST(EdgeResponse, LeadsTheBallAtAnEvenDepth) {
  static const auto box = make_surface("box");
  std::vector<double> distances;
  edge_response(proxy_setup([&](const Vector3d& p) {
    distances.push_back(box->distance(p));
    return rolled(p, 0.0);
  }));
  constexpr std::size_t kTicks = 900;  // of 957, at 0.1 mm: a quarter turn at 10 mm, and 40 mm on either side
  ASSERT_GT(distances.size(), kTicks);
  for (std::size_t i = distances.size() - kTicks; i < distances.size(); ++i)
    ASSERT_NEAR(distances[i], 0.5 * kBall, 1e-9);
}

TEST(Crossings, AreNotAnsweredWithoutAProxy) {
  const EvaluationSetup none = proxy_setup([](const Vector3d& p) { return p; });
  EXPECT_TRUE(std::isnan(edge_response(none).off.max));
  EXPECT_TRUE(std::isnan(edge_response(none).where));
  EXPECT_TRUE(edge_response(none).error.empty());
  EXPECT_TRUE(std::isnan(step_response(none).felt.p50));
}

}  // namespace
}  // namespace palpate

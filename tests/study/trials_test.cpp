// The yardstick of trials: what fails in a known way is counted as such, and what does not is not.

#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/study/trial_place.h>
#include <palpate/study/trial_tools.h>
#include <palpate/study/trials.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kBallRadius = 0.005, kTrialStiffness = 500.0;

/// A spring out of the plane of a face or sheet towards +z, for a ball, and what may be wrong with it.
struct SpringFault {
  double late = 0.0;       ///< how much deeper the plane is felt. Unit: [m].
  bool silent = false;     ///< the proxy is right, the force is none
  bool two_sided = false;  ///< out on the side where the ball is
  bool nothing = false;    ///< no surface at all
  bool sticks = false;     ///< pulls back to where it was touched last
  double jump = 0.0;       ///< added to the force 2 ball radii deep. Unit: [N].
};

class Flat final : public ForceModel {
 public:
  Flat(double top, const SpringFault& fault) : top_(top - fault.late), fault_(fault) {}

  void reset() override {}
  ForceOutput evaluate(const ForceInput& input) override {
    const double above = input.tool.position.z() - top_;
    const double side = fault_.two_sided && above < 0.0 ? -1.0 : 1.0;
    const double depth = kBallRadius - side * above;
    if (fault_.nothing || !(depth > 0.0)) {
      const Vector3d pull = fault_.sticks && touched_ ? Vector3d(-Vector3d::UnitZ()) : Vector3d::Zero();
      return {{pull, Vector3d::Zero()}, input.tool};
    }
    touched_ = true;
    Pose proxy = input.tool;
    proxy.position.z() += side * depth;
    const double force = kTrialStiffness * depth + (depth > 2.0 * kBallRadius ? fault_.jump : 0.0);
    return {{fault_.silent ? Vector3d::Zero().eval() : Vector3d(side * force * Vector3d::UnitZ()),
             Vector3d::Zero()},
            proxy};
  }

 private:
  double top_;
  SpringFault fault_;
  bool touched_ = false;
};

TrialSetup trial_setup(const std::string& place, const SpringFault& fault = {}) {
  TrialSetup setup;
  setup.place = place;
  setup.tool = Tool(Vector3d::Constant(kBallRadius));
  setup.stiffness = kTrialStiffness;
  setup.strokes = 16;
  const double top = TrialPlace(place, setup.tool, 0).top();
  setup.model = [=](const SceneIndex&, const Tool&, double) { return std::make_unique<Flat>(top, fault); };
  return setup;
}

class Faces : public testing::TestWithParam<const char*> {};

TEST_P(Faces, FindsNoFaultWithTheTruth) {
  const TrialFigures f = run_trials(trial_setup(GetParam()));
  EXPECT_EQ(f.strokes, 16U);
  EXPECT_GT(f.onsets, 0U);
  EXPECT_EQ(f.silent, 0U);
  EXPECT_EQ(f.sunk, 0U);
  EXPECT_EQ(f.through, 0U);
  EXPECT_EQ(f.stuck, 0U);
  EXPECT_NEAR(f.onset.p50, 0.0, 1e-3);  // from what is seen of noisy Gaussians
  EXPECT_EQ(f.within_1mm, 1.0);
  EXPECT_NEAR(f.magnitude.p50, 1.0, 0.1);
  EXPECT_LE(f.step.max, 1e-9);
}

TEST_P(Faces, SeesAForceThatBeginsLate) {
  const TrialFigures f = run_trials(trial_setup(GetParam(), {.late = 0.005}));
  EXPECT_NEAR(f.late.p50, 0.005, 1e-3);
  EXPECT_EQ(f.within_1mm, 0.0);
  EXPECT_EQ(f.late_strokes.size(), f.onsets);
}

TEST_P(Faces, SeesAForceThatJumps) {
  EXPECT_NEAR(run_trials(trial_setup(GetParam(), {.jump = 2.0})).step.max, 2.0,
              0.01);  // less what the way is aslant
}

INSTANTIATE_TEST_SUITE_P(Places, Faces, testing::Values("face", "sheet"));

TEST(Trials, SeeThatNothingIsFelt) {
  const TrialFigures f = run_trials(trial_setup("face", {.silent = true}));
  EXPECT_EQ(f.silent, f.strokes);
  EXPECT_EQ(f.sunk, 0U);
  EXPECT_TRUE(std::isnan(f.late.p50));
  EXPECT_EQ(f.within_1mm, 0.0);
  EXPECT_EQ(f.silent_strokes.size(), f.strokes);
}

TEST(Trials, SeeThatTheProxySinks) {
  const TrialFigures f = run_trials(trial_setup("face", {.nothing = true}));
  EXPECT_EQ(f.silent, f.strokes);
  EXPECT_EQ(f.sunk, f.strokes);
  EXPECT_EQ(f.through, 0U);  // there is no other side within reach
}

TEST(Trials, SeeASheetThatLetsThrough) {
  const TrialFigures f = run_trials(trial_setup("sheet", {.two_sided = true}));
  EXPECT_EQ(f.through, f.strokes);
  EXPECT_EQ(f.through_strokes.front(), 0U);
}

TEST(Trials, SeeAForceThatIsLeft) {
  const TrialFigures f = run_trials(trial_setup("face", {.sticks = true}));
  EXPECT_EQ(f.stuck, f.strokes);
  EXPECT_EQ(f.silent + f.sunk, 0U);
}

// Where the tool meets the true plane, to half of a tick's way.
TEST_P(Faces, TellWhereOnTheWayTheForceBegins) {
  const TrialSetup truth = trial_setup(GetParam());
  std::size_t slow = 0;
  for (std::size_t i = 0; i < truth.strokes; ++i) {
    const TrialStroke stroke = repeat_trial(truth, i, nullptr);
    if (!stroke.slow()) continue;
    ++slow;
    ASSERT_TRUE(stroke.met && stroke.felt && stroke.touched && stroke.seen);
    EXPECT_LE(std::abs(*stroke.felt - *stroke.met), 0.5e-3 * stroke.speed + 1e-9) << i;
    EXPECT_NEAR(*stroke.seen, *stroke.met, 0.002) << i;  // of noisy Gaussians
  }
  EXPECT_GT(slow, 3U);
}

// As where the tip of something long pokes through, and its middle does not.
TEST(Trials, SeeASheetThatIsSunkInto) {
  const TrialFigures f = run_trials(trial_setup("sheet", {.late = 0.004}));
  EXPECT_EQ(f.sunk, f.strokes);
  EXPECT_EQ(f.through + f.silent, 0U);
}

// Wherever a ball is pushed at, nothing in the way is seen to be nothing.
TEST(Trials, AimAtSomethingEverywhere) {
  for (const std::string_view place : trial_places()) {
    TrialSetup nothing = trial_setup("face", {.nothing = true});
    nothing.place = place;
    const TrialFigures f = run_trials(nothing);
    EXPECT_EQ(f.onsets, place == "inside" ? 0U : f.slow) << place;
    const bool thin = place == "plate" || place == "sheet";
    EXPECT_EQ(f.through, thin ? f.strokes : 0U) << place;
    // A corner may be grazed.
    if (!thin && place != "hole") {
      EXPECT_GE(f.sunk, f.strokes - 1) << place;
    }
  }
}

TEST(Trials, LetOutWhereTheToolStartsInside) {
  const TrialFigures f = run_trials(trial_setup("inside"));
  EXPECT_EQ(f.silent + f.sunk, 0U);
}

// A stroke alone is the stroke among the others, with the model that has a memory.
TEST(Trials, CanBeRepeatedAlone) {
  TrialSetup proxy = trial_setup("edge");
  proxy.tool = *trial_tool("disc");
  proxy.model = [](const SceneIndex& index, const Tool& tool, double) {
    return std::make_unique<ProxyForce>(index, tool);
  };
  proxy.strokes = 6;
  const TrialFigures f = run_trials(proxy), again = run_trials(proxy);
  EXPECT_EQ(f.step.max, again.step.max);
  double largest = 0.0;
  std::size_t slow = 0;
  for (std::size_t i = 0; i < proxy.strokes; ++i) {
    std::vector<TrialTick> ticks;
    const TrialStroke stroke = repeat_trial(proxy, i, &ticks);
    EXPECT_GT(ticks.size(), 10U);
    EXPECT_NEAR((ticks.front().tool - ticks.back().tool).norm(), 0.0, 1e-12);
    if (!stroke.slow()) continue;
    ++slow;
    largest = std::max(largest, stroke.step);
  }
  EXPECT_EQ(slow, f.slow);
  EXPECT_EQ(largest, f.step.max);
  proxy.seed = 2;
  EXPECT_NE(run_trials(proxy).step.max, f.step.max);
}

struct Sinks {
  const char *tool, *place;
};

class ToolsThatAreNotRound : public testing::TestWithParam<Sinks> {};

// Nothing rubs: a rod, disc or plate slides and turns on what it lies on, and stays out of it.
TEST_P(ToolsThatAreNotRound, DoNotSinkInWhereTheySlide) {
  const Tool tool = *trial_tool(GetParam().tool);
  const ForceModelMaker model = [](const SceneIndex& index, const Tool& held, double) {
    return std::make_unique<ProxyForce>(index, held, ProxyParameters{.stiffness = kTrialStiffness});
  };
  const TrialFigures figures = run_trials({.place = GetParam().place,
                                           .tool = tool,
                                           .model = model,
                                           .stiffness = kTrialStiffness,
                                           .strokes = 30,
                                           .seed = 9});
  EXPECT_EQ(figures.sunk, 0U) << "stroke " << (figures.sunk > 0 ? figures.sunk_strokes.front() : 0U);
  EXPECT_EQ(figures.through, 0U);
}

INSTANTIATE_TEST_SUITE_P(Places, ToolsThatAreNotRound,
                         testing::Values(Sinks{"rod", "face"}, Sinks{"rod", "plate"}, Sinks{"plate", "edge"},
                                         Sinks{"plate", "hole"}, Sinks{"disc", "edge"}),
                         [](const auto& info) {
                           return std::string(info.param.tool) + "_" + info.param.place;
                         });

TEST(Deepest, IsThatOfTheLowestPoint) {
  const TrialPlace face("face", Tool(Vector3d::Constant(0.02)), 0);
  const double top = face.top();
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Vector3d(1.0, 2.0, -0.5).normalized()));
  for (const char* name : {"ball2", "rod", "needle", "disc"}) {
    const Tool tool = turned(*trial_tool(name), turn);
    const double reach = tool.support(-Vector3d::UnitZ());
    for (const double depth : {-0.003, 0.001, 0.01}) {
      const Pose pose{{0.0, 0.0, top + reach - depth}, Eigen::Quaterniond::Identity()};
      EXPECT_NEAR(deepest(face.surface(), tool, pose), depth, 1e-9) << name;
    }
  }
}

TEST(TrialTools, AreKnownByName) {
  for (const std::string_view name : trial_tools()) EXPECT_TRUE(trial_tool(name)) << name;
  EXPECT_FALSE(trial_tool("spoon"));
  EXPECT_EQ(trial_tool("disc")->thinnest(), 0.005);
}

}  // namespace
}  // namespace palpate

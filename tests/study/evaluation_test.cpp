// The yardstick itself: a model that knows the surface must come out perfect, and one that pulls in must not.

#include <cmath>
#include <memory>
#include <numbers>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/study/evaluation.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kRadius = 0.02, kStiffness = 800.0;

/// A spring out of the true surface, for a ball, and what may be wrong with it.
struct Knowledge {
  double sign = 1.0;       ///< of the force
  bool two_sided = false;  ///< out of a sheet the nearest way
  double friction = 0.0;   ///< its own, whatever is asked for
  double creep = 0.0;      ///< of the proxy. Unit: [m] a tick.
  double ripple = 0.0;     ///< share by which the force is more and less, in turn
  bool proxy = true;       ///< has one
  bool tires = false;      ///< holds one contact, and no other until it is reset
};

class Knowing final : public ForceModel {
 public:
  Knowing(const std::string& shape, const Knowledge& knowledge)
      : surface_(make_surface(shape)), knows_(knowledge) {}

  void reset() override {
    crept_ = 0.0;
    held_ = tired_ = more_ = false;
  }
  ForceOutput evaluate(const ForceInput& input) override {
    const NearestPoint nearest = surface_->project(input.tool.position);
    const double above = (input.tool.position - nearest.point).dot(nearest.normal);
    const bool other_side = knows_.two_sided && above < 0.0;
    const Vector3d out = other_side ? Vector3d(-nearest.normal) : nearest.normal;
    const double depth = kRadius - (knows_.two_sided ? std::abs(above) : above);
    tired_ = tired_ || (knows_.tires && held_ && !(depth > 0.0));
    if (!(depth > 0.0) || tired_) return {Wrench{}, input.tool};
    held_ = true;
    more_ = !more_;
    const double size = kStiffness * depth * (1.0 + (more_ ? 1.0 : -1.0) * knows_.ripple);
    crept_ += knows_.creep;
    Pose proxy = input.tool;
    if (knows_.sign > 0.0 && knows_.proxy) proxy.position += depth * out + crept_ * out.unitOrthogonal();
    const Vector3d& v = input.velocity.linear;
    const Vector3d tangential = v - v.dot(out) * out;
    const Vector3d drag = knows_.friction * tangential.stableNormalized();
    return {{knows_.sign * size * (out - drag), Vector3d::Zero()}, proxy};
  }

 private:
  std::unique_ptr<AnalyticSurface> surface_;
  Knowledge knows_;
  double crept_ = 0.0;
  bool held_ = false, tired_ = false, more_ = false;
};

EvaluationSetup setup(const std::string& shape, const Knowledge& knowledge = {}) {
  EvaluationSetup setup;
  setup.shape = shape;
  setup.scene.spacing = 0.01;
  setup.stiffness = kStiffness;
  setup.places = 10;
  setup.pushes = 10;
  setup.model = [=](const SceneIndex&, const Tool&, double) {
    return std::make_unique<Knowing>(shape, knowledge);
  };
  return setup;
}

class Yardstick : public testing::TestWithParam<const char*> {};

TEST_P(Yardstick, FindsNoFaultWithTheTruth) {
  const Evaluation e = evaluate(setup(GetParam()));
  EXPECT_LE(e.direction.max, 1e-4);
  EXPECT_NEAR(e.magnitude.p05, 1.0, 1e-9);
  EXPECT_NEAR(e.magnitude.max, 1.0, 1e-9);
  EXPECT_EQ(e.silent, 0U);
  EXPECT_EQ(e.flipped, 0U);
  EXPECT_GE(e.onset.p05, 0.0);
  EXPECT_LE(e.onset.max, 1.01e-4);  // a tick's way
  EXPECT_LE(e.ripple.max, 1e-6);
  for (const CurvePoint& p : e.force_at)
    EXPECT_NEAR(p.value.p50, kStiffness * p.at, kStiffness * 1.01e-4) << p.at;
  for (const double force : e.held) EXPECT_NEAR(force, kStiffness * 0.5 * kRadius, 1e-9);
  EXPECT_EQ(e.held.size(), 10U);
  EXPECT_EQ(e.pushes, 10U);
  EXPECT_EQ(e.through, 0U);
  EXPECT_LE(e.loop.max, 1e-6);
}

TEST_P(Yardstick, SeesAForceThatPullsIn) {
  const Evaluation e = evaluate(setup(GetParam(), {.sign = -1.0}));
  EXPECT_NEAR(e.direction.p05, 180.0, 1e-3);
  EXPECT_GT(e.flipped, 1000U);
  EXPECT_EQ(e.through, e.pushes);
}

INSTANTIATE_TEST_SUITE_P(Shapes, Yardstick,
                         testing::Values("sphere", "cylinder", "torus", "box", "plane", "shell", "step"));

// A place near the rim of the open half sphere: what is pushed far aslant there goes around it, and is not
// through.
TEST(Pushes, KeepAwayFromTheBorderOfASheet) {
  for (const char* sheet : {"plane", "shell"}) {
    EvaluationSetup many = setup(sheet);
    many.places = 1;
    many.pushes = 2000;
    many.seed = 3;
    many.model = [=](const SceneIndex&, const Tool&, double) {
      return std::make_unique<Knowing>(sheet, Knowledge{});
    };
    const Evaluation e = evaluate(many);
    EXPECT_EQ(e.pushes, 2000U);
    EXPECT_EQ(e.fast, 200U);
    EXPECT_EQ(e.through, 0U);
  }
}

TEST(Pushes, SeesASheetThatLetsThrough) {
  for (const char* sheet : {"plane", "shell", "step"}) {
    const Evaluation e = evaluate(setup(sheet, {.two_sided = true}));
    EXPECT_EQ(e.through, e.pushes);
    EXPECT_EQ(e.fast_through, e.fast);
  }
}

/// Where a tool has been since its last reset, for whoever looks on.
class Recording final : public ForceModel {
 public:
  explicit Recording(std::vector<std::vector<Vector3d>>& ways) : ways_(ways) {}
  void reset() override { ways_.emplace_back(); }
  ForceOutput evaluate(const ForceInput& input) override {
    ways_.back().push_back(input.tool.position);
    return {Wrench{}, input.tool};
  }

 private:
  std::vector<std::vector<Vector3d>>& ways_;
};

EvaluationSetup recording(std::vector<std::vector<Vector3d>>& ways) {
  EvaluationSetup setup = palpate::setup("plane");
  setup.model = [&](const SceneIndex&, const Tool&, double) { return std::make_unique<Recording>(ways); };
  return setup;
}

// From two and a half of the tool's radii before its centre to three beyond.
TEST(Pushes, AreAslantByUpTo30Degrees) {
  std::vector<std::vector<Vector3d>> ways;
  EvaluationSetup many = recording(ways);
  many.places = 1;
  many.pushes = 500;
  evaluate(many);
  ASSERT_GT(ways.size(), many.pushes);
  double widest = 0.0;
  Vector3d aside = Vector3d::Zero();
  for (std::size_t i = ways.size() - many.pushes; i < ways.size(); ++i) {
    const Vector3d way = ways[i].back() - ways[i].front(), along = way.normalized();
    EXPECT_NEAR(way.norm(), 5.5 * kRadius, 2.1e-3);  // of a tick, at 2 m/s
    widest = std::max(widest, std::acos(-along.z()) * 180.0 / std::numbers::pi);
    aside += Vector3d(along.x(), along.y(), 0.0) / static_cast<double>(many.pushes);
  }
  EXPECT_LE(widest, 30.0);
  EXPECT_GT(widest, 29.0);
  EXPECT_LT(aside.norm(), 0.06);
}

// A model with friction 0.3 holds a tool 10 mm deep that is 3 mm aside: it rests at half of that.
TEST(Friction, IsNoCreepWhereTheToolRestsAsideByHalfOfWhatMakesItSlip) {
  std::vector<std::vector<Vector3d>> ways;
  EvaluationSetup rubbed = recording(ways);
  rubbed.friction = 0.3;
  rubbed.places = 2;
  rubbed.pushes = 0;
  evaluate(rubbed);
  int rests = 0;
  for (const std::vector<Vector3d>& way : ways) {
    if (way.size() < 10'000) continue;
    ++rests;
    for (std::size_t tick = way.size() - 10'000; tick < way.size(); ++tick) ASSERT_EQ(way[tick], way.back());
    EXPECT_NEAR(way.back().z(), 0.010, 1e-9);
    EXPECT_NEAR((way.back() - way.front()).head<2>().norm(), 0.0015, 1e-9);
  }
  EXPECT_EQ(rests, 2);
}

// Without a proxy, what pushes back lets nothing through, however deep, and what pushes on does.
TEST(Pushes, OfAModelWithoutAProxyAreJudgedByItsForce) {
  for (const char* sheet : {"plane", "shell"}) {
    EXPECT_EQ(evaluate(setup(sheet, {.proxy = false})).through, 0U);
    const Evaluation e = evaluate(setup(sheet, {.two_sided = true, .proxy = false}));
    EXPECT_EQ(e.through, e.pushes);
  }
}

// What a stroke has left behind is nothing to the next.
TEST(Evaluation, BeginsEveryStrokeAnew) {
  EvaluationSetup fresh = setup("sphere"), tiring = setup("sphere", {.tires = true});
  fresh.friction = tiring.friction = 0.3;
  fresh.places = tiring.places = 2;
  const Evaluation one = evaluate(fresh), other = evaluate(tiring);
  EXPECT_EQ(one.pushes, other.pushes);
  EXPECT_EQ(one.through, other.through);
  EXPECT_EQ(one.silent, other.silent);
  EXPECT_EQ(one.held, other.held);
  EXPECT_EQ(one.loop.max, other.loop.max);
  EXPECT_EQ(one.ripple.max, other.ripple.max);
  EXPECT_EQ(one.friction.p50, other.friction.p50);
  EXPECT_EQ(one.creep.max, other.creep.max);
}

// A model that feels nothing is no wall.
TEST(Pushes, SeesThatNothingIsInTheWay) {
  class Nothing final : public ForceModel {
    void reset() override {}
    ForceOutput evaluate(const ForceInput& input) override { return {Wrench{}, input.tool}; }
  };
  EvaluationSetup nothing = setup("sphere");
  nothing.model = [](const SceneIndex&, const Tool&, double) { return std::make_unique<Nothing>(); };
  const Evaluation e = evaluate(nothing);
  EXPECT_EQ(e.through, e.pushes);
  EXPECT_TRUE(std::isnan(e.onset.p50));
  EXPECT_GT(e.silent, 0U);
}

TEST(Pushes, NeedASheetThatIsLargeEnough) {
  EvaluationSetup large = setup("shell");
  large.tool = Tool{Vector3d::Constant(0.06)};
  EXPECT_THAT(test::message_of<Error>([&] { evaluate(large); }), testing::HasSubstr("tool of 60 mm"));
}

class Friction : public testing::TestWithParam<const char*> {};

TEST_P(Friction, IsThatOfTheModelAndNotTheOneAskedFor) {
  EvaluationSetup rubbed = setup(GetParam(), {.friction = 0.4});
  rubbed.friction = 0.3;
  const Evaluation e = evaluate(rubbed);
  EXPECT_NEAR(e.friction.p05, 0.4, 2e-3);  // curved, a tick's way is not quite a tangent
  EXPECT_NEAR(e.friction.max, 0.4, 2e-3);
  EXPECT_NEAR(e.creep.max, 0.0, 1e-12);
}

TEST_P(Friction, SeesAProxyThatCreeps) {
  EvaluationSetup creeping = setup(GetParam(), {.creep = 1e-7});
  creeping.friction = 0.3;
  creeping.places = 2;
  EXPECT_NEAR(evaluate(creeping).creep.max, 1e-3, 1e-9);  // 10,000 ticks
}

INSTANTIATE_TEST_SUITE_P(Shapes, Friction, testing::Values("plane", "sphere", "torus"));

TEST(Friction, IsMeasuredForEveryCoefficientAskedFor) {
  EvaluationSetup rubbed = setup("plane");
  rubbed.model = [](const SceneIndex&, const Tool&, double friction) {
    return std::make_unique<Knowing>("plane", Knowledge{.friction = 0.5 * friction});
  };
  const Curve curve = friction_response(rubbed, {0.2, 0.6});
  ASSERT_EQ(curve.size(), 2U);
  EXPECT_EQ(curve[1].at, 0.6);
  EXPECT_NEAR(curve[0].value.p50, 0.1, 1e-6);
  EXPECT_NEAR(curve[1].value.max, 0.3, 1e-6);
}

// It is measured where the proxy is, and not where the tool is: here the proxy lags behind by 30 mm of a
// sphere of 150 mm.
TEST(Friction, IsAgainstTheNormalOfTheProxy) {
  class Lagging final : public ForceModel {
    void reset() override {}
    ForceOutput evaluate(const ForceInput& input) override {
      const NearestPoint below = surface_->project(input.tool.position);
      const Vector3d v = input.velocity.linear,
                     along = (v - v.dot(below.normal) * below.normal).stableNormalized();
      const NearestPoint there = surface_->project(below.point - 0.03 * along);
      const Vector3d drag = (along - along.dot(there.normal) * there.normal).stableNormalized();
      Pose proxy = input.tool;
      proxy.position = there.point + kRadius * there.normal;
      return {{kStiffness * 0.01 * (there.normal - 0.25 * drag), Vector3d::Zero()}, proxy};
    }
    std::unique_ptr<AnalyticSurface> surface_ = make_surface("sphere");
  };
  EvaluationSetup rubbed = setup("sphere");
  rubbed.model = [](const SceneIndex&, const Tool&, double) { return std::make_unique<Lagging>(); };
  EXPECT_NEAR(friction_response(rubbed, {0.3})[0].value.p50, 0.25, 2e-3);
}

// A tenth more and a tenth less, in turn: that is the standard deviation, and twice that the jump.
TEST(Slides, TellRippleAndJump) {
  const Evaluation e = evaluate(setup("plane", {.ripple = 0.1}));
  EXPECT_NEAR(e.ripple.p50, 0.1, 1e-3);
  EXPECT_NEAR(e.jump.p50, 0.2 * kStiffness * 0.5 * kRadius, 1e-9);
  ASSERT_GT(e.slide.size(), 1U);
  EXPECT_NEAR(e.slide[1].x() - e.slide[0].x(), 1e-4, 1e-12);
  EXPECT_NEAR(std::abs(e.slide[1].y() - e.slide[0].y()), 0.2 * kStiffness * 0.5 * kRadius, 1e-9);
  EXPECT_NEAR(e.slide_depth, 0.5 * kRadius, 1e-12);
}

// Around a circle as wide as deep, rubbed by mu: mu k depth 2 pi depth, over k depth^2 / 2.
TEST(Loops, TellTheWorkThatFrictionDoes) {
  const Evaluation e = evaluate(setup("plane", {.friction = 0.4}));
  EXPECT_NEAR(e.loop.p50, 4.0 * std::numbers::pi * 0.4, 0.02);
}

TEST(Evaluation, TellsHowFarItIs) {
  std::vector<double> told;
  evaluate(setup("plane"), [&](std::string_view, double fraction) { told.push_back(fraction); });
  ASSERT_EQ(told.size(), 20U);  // 10 places and 10 pushes
  for (std::size_t k = 0; k < told.size(); ++k)
    EXPECT_NEAR(told[k], (static_cast<double>(k) + 1.0) / 20.0, 1e-12);
}

TEST(Friction, IsNotMeasuredWhereThereIsNone) {
  const Evaluation e = evaluate(setup("plane"));
  EXPECT_TRUE(std::isnan(e.friction.p50));
  EXPECT_TRUE(std::isnan(e.creep.max));
}

// Its lowest point, not its centre and not its longest axis, tells how deep a long tool is.
TEST(Evaluation, KnowsWhereALongToolTouches) {
  class Plane final : public ForceModel {
    void reset() override {}
    ForceOutput evaluate(const ForceInput& input) override {
      const double depth = 0.03 - input.tool.position.z();
      if (!(depth > 0.0)) return {Wrench{}, input.tool};
      return {{kStiffness * depth * Vector3d::UnitZ(), Vector3d::Zero()}, input.tool};
    }
  };
  EvaluationSetup longer = setup("plane");
  longer.tool = Tool(Vector3d(0.02, 0.01, 0.03));
  longer.model = [](const SceneIndex&, const Tool&, double) { return std::make_unique<Plane>(); };
  const Evaluation e = evaluate(longer);
  EXPECT_NEAR(e.magnitude.p05, 1.0, 1e-9);
  EXPECT_NEAR(e.magnitude.max, 1.0, 1e-9);
}

TEST(ForceRatio, IsOneForAModelThatDoesNotCountAndTheRatioOfCountsForOneThatDoes) {
  EvaluationSetup coarse = setup("plane"), fine = coarse;
  fine.scene.spacing = 0.005;
  EXPECT_DOUBLE_EQ(force_ratio(evaluate(fine), evaluate(coarse)).p50, 1.0);

  class Counting final : public ForceModel {
   public:
    explicit Counting(std::size_t count) : count_(static_cast<double>(count)) {}
    void reset() override {}
    ForceOutput evaluate(const ForceInput& input) override {
      return {{1e-3 * count_ * Vector3d::UnitZ(), Vector3d::Zero()}, input.tool};
    }

   private:
    double count_;
  };
  coarse.model = fine.model = [](const SceneIndex& index, const Tool&, double) {
    return std::make_unique<Counting>(index.size());
  };
  EXPECT_NEAR(force_ratio(evaluate(fine), evaluate(coarse)).p50, 4.0, 1e-9);  // 40 x 40 and 80 x 80
}

TEST(Evaluation, IsTheSameEveryTimeAndAnotherForAnotherSeed) {
  EvaluationSetup one = setup("sphere");
  one.model = [](const SceneIndex& index, const Tool& tool, double) {
    return std::make_unique<ProxyForce>(index, tool);
  };
  one.scene.noise = 0.001;
  const Evaluation first = evaluate(one), again = evaluate(one);
  EXPECT_EQ(first.direction.p50, again.direction.p50);
  EXPECT_EQ(first.jump.max, again.jump.max);
  one.seed = 2;
  EXPECT_NE(evaluate(one).direction.p50, first.direction.p50);
}

TEST(Evaluation, RefusesAToolThatFitsNowhere) {
  EvaluationSetup large = setup("torus");
  large.tool = Tool{Vector3d::Constant(2.0)};
  EXPECT_THAT(test::message_of<Error>([&] { evaluate(large); }), testing::HasSubstr("tool of 2000 mm"));
}

}  // namespace
}  // namespace palpate

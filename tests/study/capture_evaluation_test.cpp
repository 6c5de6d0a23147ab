// The yardstick for captures: a model that knows where the scene is seen must come out perfect, and each kind
// of error must be found where it was made.

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include <palpate/haptics/proxy_force.h>
#include <palpate/study/capture_evaluation.h>

#include "support/splats.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kBenchRadius = 0.01, kBenchStiffness = 400.0;
constexpr double kSplatSpacing = 0.003;

/// Flat, opaque splats in the plane z = `level`, where |x| and |y| <= `end`.
std::vector<test::Splat> sheet(double level = 0.0, double end = 0.135) {
  std::vector<test::Splat> splats;
  const int last = static_cast<int>(end / kSplatSpacing);
  for (int i = -last; i <= last; ++i)
    for (int k = -last; k <= last; ++k)
      splats.push_back(test::splat({kSplatSpacing * i, kSplatSpacing * k, level},
                                   {kSplatSpacing, kSplatSpacing, 1e-5}, Eigen::Quaterniond::Identity(),
                                   0.95));
  return splats;
}

/// What is too faint for the filter is seen, if there is much of it, and is no ellipsoid to be touched.
std::vector<test::Splat> faint_sheets() {
  std::vector<test::Splat> faint{test::splat({0.0, 0.0, -1.0}, {0.01, 0.01, 0.01})};
  for (int layer = 0; layer < 20; ++layer)
    for (test::Splat splat : sheet(-0.0005 * layer)) {
      splat.opacity = 0.08;
      faint.push_back(splat);
    }
  return faint;
}

/// A spring out of the plane z = 0, and what may be wrong with it.
struct PlaneKnowledge {
  double early = 0.0;  ///< by how much it begins above. Unit: [m].
  double gain = 1.0;
  double jump = 0.0;  ///< of the force, 4 mm deep. Unit: [N].
  double edge = 0.0;  ///< of the force, 50 mm from the z axis. Unit: [N].
};

class PlaneSpring final : public ForceModel {
 public:
  explicit PlaneSpring(const PlaneKnowledge& knows) : knows_(knows) {}
  void reset() override {}
  ForceOutput evaluate(const ForceInput& input) override {
    const double depth = kBenchRadius - input.tool.position.z() + knows_.early;
    ForceOutput felt{Wrench{}, input.tool};
    if (depth > 0.0) felt.wrench.force.z() = knows_.gain * kBenchStiffness * depth;
    if (depth > 0.00405) felt.wrench.force.z() += knows_.jump;
    if (input.tool.position.head<2>().norm() > 0.05005) felt.wrench.force.z() += knows_.edge;
    return felt;
  }

 private:
  PlaneKnowledge knows_;
};

struct Bench {
  explicit Bench(const std::vector<test::Splat>& splats, const ForceModelMaker& model)
      : index(test::scene_of(splats), SceneFilter{}, Similarity{}),
        seen(test::scene_of(splats), Similarity{}),
        evaluation(index, seen, tool, model, kBenchStiffness) {}
  Bench(const std::vector<test::Splat>& splats, const PlaneKnowledge& knows)
      : Bench(splats, [knows](const SceneIndex&, const Tool&, double) {
          return std::make_unique<PlaneSpring>(knows);
        }) {}

  CaptureAim down() const {
    const Vector3d from(0, 0, 0.2);
    return {from, -Vector3d::UnitZ(), *seen.first_touch(tool, from, -Vector3d::UnitZ())};
  }
  CaptureFigures push() {
    last = evaluation.push(down());
    return evaluation.figures({last}, {});
  }
  CaptureFigures slide() {
    const CaptureSlide slide = evaluation.slide(down());
    way = slide.way;
    return evaluation.figures({}, {slide});
  }

  Tool tool{Vector3d::Constant(kBenchRadius)};
  SceneIndex index;
  SeenSurface seen;
  CaptureEvaluation evaluation;
  CapturePush last;
  double way = 0.0;
};

TEST(CaptureEvaluation, WhoKnowsTheSurfaceIsRight) {
  Bench bench(sheet(), PlaneKnowledge{});
  EXPECT_NEAR(bench.down().seen, 0.19, 1e-6);
  const CaptureFigures figures = bench.push();
  EXPECT_EQ(figures.onset_within, 1.0);
  EXPECT_EQ(figures.late + figures.early + figures.silent_5mm + figures.silent_10mm + figures.untouched, 0.0);
  EXPECT_NEAR(figures.onset.p50, 0.0, 2e-4);
  EXPECT_NEAR(*bench.last.touched, 0.0, 2e-4);
  EXPECT_NEAR(bench.last.step, 0.0, 1e-9) << "a spring moves by no more than k times the motion";
}

TEST(CaptureEvaluation, WhatBeginsLateIsSilent) {
  Bench bench(sheet(), PlaneKnowledge{.early = -0.007});
  const CaptureFigures figures = bench.push();
  EXPECT_EQ(figures.late, 1.0);
  EXPECT_EQ(figures.silent_5mm, 1.0);
  EXPECT_EQ(figures.silent_10mm, 0.0);
  EXPECT_NEAR(figures.onset.p50, 0.007, 2e-4);
}

// However hard it pushes farther in.
TEST(CaptureEvaluation, WhatIsSilentAt10MillimetresIsSoWhateverFollows) {
  EXPECT_EQ(Bench(sheet(), PlaneKnowledge{.early = -0.012}).push().silent_10mm, 1.0);
}

TEST(CaptureEvaluation, APushComesBackTheWayItWent) {
  Bench bench(sheet(), PlaneKnowledge{});
  std::vector<CaptureTick> ticks;
  bench.evaluation.push(bench.down(), &ticks);
  ASSERT_FALSE(ticks.empty());
  EXPECT_NEAR(ticks[ticks.size() / 2].depth, 3.0 * kBenchRadius, 2e-4);
  for (std::size_t i = 0; i < ticks.size() / 2; ++i)
    EXPECT_NEAR((ticks[i].tool - ticks[ticks.size() - 1 - i].tool).norm(), 0.0, 1e-12);
}

TEST(CaptureEvaluation, WhatBeginsEarlyPushesBeforeAnythingIsTouched) {
  Bench bench(sheet(), PlaneKnowledge{.early = 0.007});
  const CaptureFigures figures = bench.push();
  EXPECT_EQ(figures.early, 1.0);
  EXPECT_EQ(figures.untouched, 1.0);
  EXPECT_NEAR(bench.last.untouched_force, 0.007 * kBenchStiffness, 0.1);
}

TEST(CaptureEvaluation, NothingIsSilentAndLate) {
  Bench bench(sheet(), PlaneKnowledge{.gain = 0.0});
  const CaptureFigures figures = bench.push();
  EXPECT_EQ(figures.late, 1.0);
  EXPECT_EQ(figures.silent_10mm, 1.0);
}

// On a sheet a rigid tool is held; at its end, which the ball touches with its flank, one slips off to the
// side.
TEST(CaptureEvaluation, SilenceIsAvoidableWhereARigidToolIsHeld) {
  EXPECT_EQ(Bench(sheet(), PlaneKnowledge{.early = -0.007}).push().avoidable_5mm, 1.0);
  EXPECT_EQ(Bench(sheet(), PlaneKnowledge{}).push().avoidable_5mm, 0.0);
  Bench bench(sheet(0.0, 0.04), PlaneKnowledge{.gain = 0.0});
  for (const double aside : {0.0, 0.0534}) {
    CaptureAim aim = bench.down();
    aim.from.x() = aside;
    aim.seen = *bench.seen.first_touch(bench.tool, aim.from, aim.along);
    const CapturePush push = bench.evaluation.push(aim);
    EXPECT_TRUE(push.silent_5mm);
    EXPECT_EQ(push.avoidable_5mm, aside == 0.0) << aim.seen;
  }
}

TEST(CaptureEvaluation, ASlideSaysWhatOfItsSilenceTouchesNothing) {
  const CaptureFigures figures = Bench(faint_sheets(), PlaneKnowledge{.gain = 0.0}).slide();
  EXPECT_EQ(figures.slide_silent, 1.0);
  EXPECT_EQ(figures.slide_silent_touched, 0.0);
}

TEST(CaptureEvaluation, SilenceIsNotAvoidableWhereNothingCanBeTouched) {
  Bench bench(faint_sheets(), PlaneKnowledge{.gain = 0.0});
  const CaptureFigures figures = bench.push();
  EXPECT_FALSE(bench.last.touched);
  EXPECT_EQ(figures.silent_5mm, 1.0);
  EXPECT_EQ(figures.avoidable_5mm, 0.0);
}

// What it has passed through on the way holds nothing up.
TEST(CaptureEvaluation, SilenceIsNotAvoidableWhereOnlySomethingFartherOutWasTouched) {
  std::vector<test::Splat> splats = faint_sheets();
  splats.push_back(
      test::splat({0.0, 0.0, 0.03}, Eigen::Vector3d::Constant(0.002), Eigen::Quaterniond::Identity(), 0.3));
  Bench bench(splats, PlaneKnowledge{.gain = 0.0});
  const CaptureFigures figures = bench.push();
  ASSERT_TRUE(bench.last.touched);
  EXPECT_LT(*bench.last.touched, -0.01);
  EXPECT_EQ(figures.silent_5mm, 1.0);
  EXPECT_EQ(figures.avoidable_5mm, 0.0);
}

TEST(CaptureEvaluation, AJumpIsFound) {
  Bench bench(sheet(), PlaneKnowledge{.jump = 0.3});
  EXPECT_NEAR(bench.push().push_step.max, 0.3, 1e-9);
  // A spring of 400 N/m might change by 0.04 N in a tick of 0.1 mm.
  EXPECT_NEAR(Bench(sheet(), PlaneKnowledge{.edge = 0.2}).slide().slide_step.max, 0.2 - 0.04, 1e-9);
}

TEST(CaptureEvaluation, SlidesAreHeldAgainstTheirDepth) {
  Bench right(sheet(), PlaneKnowledge{});
  const CaptureFigures figures = right.slide();
  EXPECT_NEAR(right.way, 0.1, 1e-9);
  EXPECT_EQ(figures.slide_strong, 0.0);
  EXPECT_EQ(figures.slide_silent, 0.0);
  EXPECT_EQ(Bench(sheet(), PlaneKnowledge{.gain = 3.2}).slide().slide_strong, 1.0);
  EXPECT_EQ(figures.slide_silent_touched, 0.0);
  const CaptureFigures weak = Bench(sheet(), PlaneKnowledge{.gain = 0.05}).slide();
  EXPECT_EQ(weak.slide_silent, 1.0);
  EXPECT_EQ(weak.slide_silent_touched, 1.0);
}

TEST(CaptureEvaluation, ASlideEndsWhereTheSurfaceFallsAway) {
  Bench bench(sheet(0.0, 0.04), PlaneKnowledge{});
  bench.slide();
  EXPECT_NEAR(bench.way, 0.045, 0.01);  // as far as the ball touches its end
}

TEST(CaptureEvaluation, TwoCapturesOfOneObjectAreCompared) {
  const ForceModelMaker proxy = [](const SceneIndex& index, const Tool& tool, double) {
    ProxyParameters parameters;
    parameters.stiffness = kBenchStiffness;
    return std::make_unique<ProxyForce>(index, tool, parameters);
  };
  Bench one(sheet(), proxy), same(sheet(), proxy), lower(sheet(-0.006), proxy);
  const CaptureLikeness alike = capture_likeness(one.evaluation, same.evaluation, {one.down()});
  EXPECT_NEAR(alike.p10, 1.0, 1e-9);
  EXPECT_NEAR(alike.p90, 1.0, 1e-9);
  EXPECT_EQ(alike.silent_in_one, 0.0);
  const CaptureLikeness apart = capture_likeness(one.evaluation, lower.evaluation, {one.down()});
  EXPECT_EQ(apart.silent_in_one, 1.0);
  // 24 mm under a sheet that is 6 mm lower, it is 24 mm of 30.
  EXPECT_NEAR(apart.p90, 24.0 / 30.0, 0.02);
  EXPECT_LT(apart.p10, 0.6);
}

// On a slope the tool goes straight, too, between the places where the scene is looked at.
TEST(CaptureEvaluation, ASlideFollowsTheSlope) {
  auto slope = sheet();
  for (test::Splat& splat : slope) splat.position.z() = 0.2 * splat.position.x() + 0.1 * splat.position.y();
  Bench bench(slope, PlaneKnowledge{});
  std::vector<CaptureTick> ticks;
  bench.evaluation.slide(bench.down(), &ticks);
  ASSERT_GT(ticks.size(), 500U);
  // Half of its 10 mm deep, along z, where it touches the corners of what are discs that lie flat.
  const Vector3d up = Vector3d(-0.2, -0.1, 1.0).normalized();
  for (const CaptureTick& tick : ticks)
    ASSERT_NEAR(tick.tool.dot(up), kBenchRadius - 0.5 * kBenchRadius * up.z(), 1.5e-3);
  for (std::size_t i = 50; i + 50 < ticks.size(); ++i) {
    const Vector3d bend = ticks[i + 1].tool - 2.0 * ticks[i].tool + ticks[i - 1].tool;
    ASSERT_LE(bend.norm(), 5e-5) << i;  // half of a tick's way, for what is seen of discs
  }
}

// Below 5 mm: of a spring that begins 2 mm early, 7/5 of the other's force there and less farther in.
TEST(CaptureEvaluation, LikenessIsThatOfWhatIsDeeperThan5Millimetres) {
  Bench one(sheet(), PlaneKnowledge{}), early(sheet(), PlaneKnowledge{.early = 0.002}),
      silent(sheet(), PlaneKnowledge{.gain = 0.0});
  const CaptureLikeness ratio = capture_likeness(one.evaluation, early.evaluation, {one.down()});
  EXPECT_NEAR(ratio.ratio.max, 1.4, 0.01);
  EXPECT_NEAR(ratio.ratio.p05, 32.0 / 30.0, 0.01);
  EXPECT_TRUE(std::isnan(capture_likeness(silent.evaluation, one.evaluation, {one.down()}).ratio.max));
}

// Of five pushes and two slides, which nobody has made. At 5 mm is still in place.
TEST(CaptureEvaluation, FiguresAreSharesOfPushesAndOfTheTicksOfSlides) {
  const Bench bench(sheet(), PlaneKnowledge{});
  const CaptureAim aim = bench.down();
  const std::vector<CapturePush> pushes{{aim, 0.005, 0.005, false, false, 1.0, 0.1},
                                        {aim, -0.005, -0.006, true, false, 1.5, 0.2},
                                        {aim, -0.006, 0.006, true, false, 2.0, 0.3},
                                        {aim, 0.007, -0.005, true, true, 0.5, 0.4, true},
                                        {aim, {}, {}, true, true, 3.0, 0.5}};
  const std::vector<CaptureSlide> slides{{aim, 0.1, 300, 30, 60, 0.7, 30}, {aim, 0.02, 100, 70, 20, 0.9, 10}};
  const CaptureFigures f = bench.evaluation.figures(pushes, slides);
  EXPECT_EQ(f.pushes, 5U);
  EXPECT_EQ(f.slides, 2U);
  EXPECT_EQ(f.onset_within, 0.4);
  EXPECT_EQ(f.early, 0.2);
  EXPECT_EQ(f.late, 0.4);
  EXPECT_EQ(f.silent_5mm, 0.8);
  EXPECT_EQ(f.silent_10mm, 0.4);
  EXPECT_EQ(f.avoidable_5mm, 0.2);
  EXPECT_EQ(f.untouched, 0.6);
  EXPECT_EQ(f.touched_within, 0.4);
  EXPECT_EQ(f.onset.max, 0.007);
  EXPECT_EQ(f.push_step.max, 0.5);
  EXPECT_EQ(f.slide_strong, 0.25);
  EXPECT_EQ(f.slide_silent, 0.2);
  EXPECT_EQ(f.slide_silent_touched, 0.1);
  EXPECT_EQ(f.slide_step.max, 0.9);
  EXPECT_TRUE(std::isnan(f.tick.p50)) << "nothing has been in contact";
  const CaptureFigures none = bench.evaluation.figures({}, {});
  EXPECT_TRUE(std::isnan(none.onset_within) && std::isnan(none.touched_within));
  EXPECT_TRUE(std::isnan(none.slide_strong) && std::isnan(none.slide_step.max));
}

TEST(CaptureEvaluation, WhatIsFoundSaysWhereItWas) {
  Bench bench(sheet(), PlaneKnowledge{});
  CaptureAim aim = bench.down();
  aim.from.x() = 0.01;
  EXPECT_EQ(bench.evaluation.push(aim).aim.from, aim.from);
  const CaptureSlide slide = bench.evaluation.slide(aim);
  EXPECT_EQ(slide.aim.from, aim.from);
  EXPECT_EQ(slide.aim.along, aim.along);
  EXPECT_EQ(slide.aim.seen, aim.seen);
}

TEST(CaptureEvaluation, AimsMeetWhatIsSeenFromOutside) {
  // A ball of splats: wherever from, the tool meets it a tool's radius above.
  constexpr double kBall = 0.05;
  std::vector<test::Splat> splats;
  constexpr int kCount = 3000;
  for (int k = 0; k < kCount; ++k) {
    const double z = 1.0 - 2.0 * (k + 0.5) / kCount, angle = 2.39996 * k, s = std::sqrt(1.0 - z * z);
    const Vector3d n(s * std::cos(angle), s * std::sin(angle), z);
    splats.push_back(test::splat(kBall * n, {0.003, 0.003, 1e-5},
                                 Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), n), 0.95));
  }
  const SeenSurface seen(test::scene_of(splats), Similarity{});
  FilterReport report;
  const EllipsoidScene kept = filter_scene(test::scene_of(splats), SceneFilter{}, Similarity{}, report);
  const Tool tool(Vector3d::Constant(kBenchRadius));
  const auto aims = capture_aims(kept, seen, tool, 30, 5);
  ASSERT_EQ(aims.size(), 30U);
  for (const CaptureAim& aim : aims) {
    EXPECT_GT(aim.from.norm(), 2.0 * kBall);
    const double away = (aim.from + aim.seen * aim.along).norm();
    EXPECT_NEAR(away, kBall + kBenchRadius, 0.002);
  }
  const auto again = capture_aims(kept, seen, tool, 30, 5);
  EXPECT_EQ(again.back().seen, aims.back().seen);
  EXPECT_NE(capture_aims(kept, seen, tool, 30, 6).back().seen, aims.back().seen);
  EXPECT_TRUE(capture_aims({}, seen, tool, 30, 5).empty());
}

}  // namespace
}  // namespace palpate

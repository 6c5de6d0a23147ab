// A hand that comes back to where it began has got nothing out of what it touched, whatever that is made of:
// what the hand feels makes no energy.

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/haptics/proxy_force.h>
#include <palpate/study/random.h>
#include <support/ball_on_surface.h>
#include <support/effort.h>
#include <support/noisy_plane.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::kRadius;

constexpr double kTick = 1e-3;
/// What may come out of a closed stroke. Unit: [J].
constexpr double kMost = 1e-3;

/// Stripes across x, `width` wide, of one stiffness and the other in turn.
std::shared_ptr<const MaterialMap> stripes(double width, double one, double other) {
  std::vector<MaterialRegion> regions{{MaterialRegion::Everywhere{}, {.stiffness = one}}};
  for (double x = 0.0; x < 0.2; x += 2.0 * width) {
    const Eigen::AlignedBox3d stripe(Vector3d(x, -1, -1), Vector3d(x + width, 1, 1));
    regions.push_back({stripe, {.stiffness = other}});
  }
  return std::make_shared<MaterialMap>(regions);
}

/// A ball that is led over a noisy plane, and the work that it does on the hand.
class Stroke {
 public:
  explicit Stroke(const ProxyParameters& parameters, double radius = kRadius)
      : model_(test::noisy_plane(), Tool(Vector3d::Constant(radius)), parameters), radius_(radius) {}

  /// To where the ball is `depth` deep in z = 0, at `speed`.
  void to(double x, double y, double depth, double speed = 0.1) {
    const Vector3d end(x, y, radius_ - depth);
    if (!begun_) at_ = end;
    begun_ = true;
    const Vector3d begin = at_;
    const int ticks = std::max(1, static_cast<int>((end - begin).norm() / (speed * kTick)));
    for (int k = 1; k <= ticks; ++k) feel(begin + static_cast<double>(k) / ticks * (end - begin));
  }

  /// Where it is. Unit: [s].
  void rest(double time) {
    for (int k = 0; k < static_cast<int>(time / kTick); ++k) feel(at_);
  }

  double work() const { return work_; }
  const Vector3d& force() const { return force_; }

 private:
  void feel(const Vector3d& position) {
    ForceInput input;
    input.tool.position = position;
    input.velocity.linear = (position - at_) / kTick;
    input.dt = kTick;
    const Vector3d force = model_.evaluate(input).wrench.force;
    work_ += 0.5 * (force + force_).dot(position - at_);
    force_ = force;
    at_ = position;
  }

  ProxyForce model_;
  double radius_;
  bool begun_ = false;
  Vector3d at_ = Vector3d::Zero(), force_ = Vector3d::Zero();
  double work_ = 0.0;
};

TEST(ProxyEnergy, NoneComesOutOfWhatIsPressedSoftAndLeftStiff) {
  for (const double friction : {0.0, 0.3}) {
    ProxyParameters parameters;
    parameters.friction = friction;
    parameters.materials = stripes(0.2, 300.0, 3000.0);
    Stroke stroke(parameters);
    stroke.to(-0.08, 0.0, -0.01);
    stroke.to(-0.08, 0.0, 0.01);
    stroke.to(0.08, 0.0, 0.01);
    EXPECT_GT(stroke.force().z(), 2.0 * 300.0 * 0.01) << "what is stiff is felt to be";
    stroke.to(0.08, 0.0, -0.01);
    EXPECT_LT(stroke.work(), kMost);
    // And pressed anew, it is as stiff as ever.
    Stroke fresh(parameters);
    for (Stroke* s : {&stroke, &fresh}) {
      s->to(0.08, 0.0, -0.01);
      s->to(0.08, 0.0, 0.005);
    }
    EXPECT_NEAR(stroke.force().z(), fresh.force().z(), 0.02 * fresh.force().z());
    EXPECT_GT(fresh.force().z(), 3000.0 * 0.005);
  }
}

TEST(ProxyEnergy, StripesAreFeltOneAfterTheOther) {
  ProxyParameters parameters;
  parameters.materials = stripes(0.06, 300.0, 3000.0);
  Stroke stroke(parameters);
  stroke.to(-0.09, 0.0, -0.01);
  stroke.to(-0.09, 0.0, 0.01);
  std::vector<double> soft, stiff;
  for (int k = 0; k < 4; ++k) {
    stroke.to(0.03, 0.0, 0.01);
    stroke.rest(0.5);  // a stiffness goes where it is to go by and by
    stiff.push_back(stroke.force().z());
    stroke.to(-0.09, 0.0, 0.01);
    stroke.rest(0.5);
    soft.push_back(stroke.force().z());
  }
  for (const double force : stiff) EXPECT_NEAR(force, stiff.front(), 0.1 * stiff.front());
  // Stiffness times depth, but for where in the noise the proxy rests, which differs between compilers.
  for (const double force : soft) EXPECT_NEAR(force, 300.0 * 0.01, 0.2 * 300.0 * 0.01);
  EXPECT_GT(stiff.back(), 2.0 * soft.back());
}

// For a hand whose world is twice as large, a way there is half as long, and what changes with it changes in
// half of the time.
TEST(ProxyEnergy, StiffnessChangesAtThePaceOfTheHand) {
  std::vector<int> ticks;
  for (const double scale : {1.0, 2.0}) {
    ProxyParameters parameters;
    parameters.hand_scale = scale;
    parameters.materials = stripes(0.2, 300.0, 3000.0);
    Stroke stroke(parameters);
    stroke.to(0.04, 0.0, -0.01);
    stroke.to(0.04, 0.0, 0.01);
    EXPECT_GT(stroke.force().z(), 0.8 * 3000.0 * 0.01);
    stroke.to(-0.04, 0.0, 0.01, 8.0);
    int count = 0;
    for (; stroke.force().z() > 2.0 * 300.0 * 0.01 && count < 5000; ++count) stroke.rest(kTick);
    ticks.push_back(count);
  }
  EXPECT_GT(ticks[0], 20);
  EXPECT_LT(ticks[1], 0.7 * ticks[0]);
}

class AtScales : public testing::TestWithParam<double> {};

/// Random strokes, in and out of the surface and along it, over stripes of any stiffness, at any speed.
TEST_P(AtScales, NoneComesOutOfAnyClosedStroke) {
  const double scale = GetParam();
  Random random(41);
  for (std::size_t k = 0; k < test::draws(8); ++k) {
    ProxyParameters parameters;
    parameters.hand_scale = scale;
    parameters.friction = random.uniform(0.0, 0.8);
    const double width = random.uniform(0.01, 0.1), soft = random.uniform(50.0, 1000.0);
    parameters.materials = stripes(width, soft, random.uniform(1000.0, 5000.0));
    Stroke stroke(parameters, random.uniform(0.005, 0.03));
    stroke.to(0.0, 0.0, -0.05);
    for (int leg = 0; leg < 8; ++leg) {
      const double speed = 0.02 * std::pow(50.0, random.uniform(0.0, 1.0));
      const double x = random.uniform(-0.1, 0.1), y = random.uniform(-0.1, 0.1);
      stroke.to(x, y, random.uniform(-0.01, 0.02), speed);
    }
    stroke.to(0.0, 0.0, -0.05);
    stroke.rest(20.0 / scale * 0.05);  // what lags behind a quick hand comes after it at the hand's pace
    EXPECT_LT(stroke.work() / (scale * scale), kMost) << k;
    EXPECT_EQ(stroke.force().norm(), 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Proxy, AtScales, testing::Values(0.05, 1.0, 50.0));

}  // namespace
}  // namespace palpate

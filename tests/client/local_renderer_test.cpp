// The local renderer of the reference client, on a clock of the test's own.
#include <client/palpate_client.h>

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <support/allocation_guard.h>
#include <support/not_finite.h>

namespace palpate_client {
namespace {

using palpate::test::kNan;

constexpr double kPeriod = LocalRenderer::kPeriod;
constexpr double kDamping = 1.0;            // N s/m
constexpr double kRenderedForceMax = 12.0;  // N
constexpr double kStiffness = 500.0;        // N/m

/// A floor that ends at `height`.
LocalModel floor_at(double height, double stiffness = kStiffness) {
  LocalModel model;
  model.planes[0] = {{0, 0, height}, {0, 0, 1}};
  model.count = 1;
  model.stiffness = stiffness;
  model.share = 1.0;
  return model;
}

class LocalRendererTest : public testing::Test {
 protected:
  Vector tick(const Vector& to) {
    place = to;
    now += kPeriod;
    const Vector force = renderer.ask(model, place, now);
    renderer.show(force);
    return force;
  }
  /// In steps of 0.1 mm or less.
  Vector go(const Vector& to) {
    const Vector from = place;
    const double way = vectors::norm(vectors::sum(to, from, -1.0));
    const int steps = std::max(1, static_cast<int>(std::ceil(way / 1e-4 - 1e-9)));
    Vector force{};
    for (int k = 1; k <= steps; ++k)
      force = tick(vectors::sum(from, vectors::sum(to, from, -1.0), static_cast<double>(k) / steps));
    return force;
  }

  void SetUp() override { tick({0, 0, 0.001}); }

  double now = 100.0;
  Vector place{};
  LocalModel model = floor_at(0.0);
  LocalRenderer renderer{{kRenderedForceMax, 0.0, kDamping}};
};

TEST_F(LocalRendererTest, AFloorIsASpring) {
  EXPECT_EQ(tick({0, 0, 5e-4})[2], 0.0);
  EXPECT_NEAR(go({0, 0, -0.001})[2], 0.5, 1e-9) << "500 N/m, 1 mm";
  EXPECT_NEAR(renderer.energy(), 2.5e-4, 1e-9);
  EXPECT_NEAR(go({0.003, 0, -0.002})[2], 1.0, 1e-9);
  EXPECT_NEAR(go({0, 0, -0.0005})[2], 0.25, 1e-9) << "and on the way back";
  EXPECT_EQ(go({0, 0, 0.001})[2], 0.0);
}

// k (L)^2 / 2 = 2.5e-4 J under 3 mm of spring: 1 mm of it is felt.
TEST_F(LocalRendererTest, AFloorThatRisesUnderAStillHandWindsUpNothing) {
  go({0, 0, -0.001});
  model = floor_at(0.002);
  EXPECT_NEAR(tick(place)[2], 0.5, 1e-9);
  for (int k = 0; k < 1000; ++k) tick(place);
  EXPECT_NEAR(tick(place)[2], 0.5, 1e-9) << "however long";
  // 0.1 mm deeper: 5e-5 J of the hand, 1e-5 J that the device has absorbed; sqrt(2 x 500 x 3.1e-4) N.
  EXPECT_NEAR(tick({0, 0, -0.0011})[2], 0.556776, 1e-5);
  for (int k = 0; k < 300; ++k) go({k % 2 * 1e-4, 0, -0.0011});
  EXPECT_NEAR(tick(place)[2], 1.55, 1e-3)
      << "all of it once the hand has moved, also along the floor: 3.1 mm";
}

TEST_F(LocalRendererTest, ASpringThatStiffensUnderAStillHandKeepsItsEnergy) {
  go({0, 0, -0.001});
  model.stiffness = 2.0 * kStiffness;
  EXPECT_NEAR(tick(place)[2], 0.5 * std::sqrt(2.0), 1e-9);
  model.stiffness = kStiffness;
  EXPECT_NEAR(tick(place)[2], 0.5, 1e-9);
  model.share = 0.5;
  EXPECT_NEAR(tick(place)[2], 0.25, 1e-9) << "half of what there was is let go";
}

TEST_F(LocalRendererTest, WhatIsGoneIsLetGoWithinTheSlew) {
  go({0, 0, -0.006});
  model.count = 0;
  const double step = kRenderedForceMax * kPeriod / LocalRenderer::kSlewTime;
  EXPECT_NEAR(tick(place)[2], 3.0 - step, 1e-9);
  EXPECT_NEAR(tick(place)[2], 3.0 - 2.0 * step, 1e-9);
  EXPECT_EQ(tick(place)[2], 0.0);
  EXPECT_EQ(renderer.energy(), 0.0);
}

TEST_F(LocalRendererTest, TheSlewIsThatOfTheTimeHoweverOftenItIsAsked) {
  go({0, 0, -0.006});
  model.count = 0;
  for (int k = 1; k <= 4; ++k) {
    now += kPeriod / 4.0;
    const Vector force = renderer.ask(model, place, now);
    renderer.show(force);
    EXPECT_NEAR(force[2], 3.0 - k * kRenderedForceMax * kPeriod / 4.0 / LocalRenderer::kSlewTime, 1e-9);
  }
}

TEST_F(LocalRendererTest, ACornerPushesOutOfAllItsPlanes) {
  model.planes[1] = {{-0.001, 0, 0}, {1, 0, 0}};
  model.count = 2;
  const Vector force = go({-0.003, 0, -0.001});
  EXPECT_NEAR(force[0], 1.0, 1e-6);
  EXPECT_NEAR(force[2], 0.5, 1e-6);
}

TEST_F(LocalRendererTest, FrictionSticksAndThenSlips) {
  model.friction = 0.5;
  go({0, 0, -0.001});
  EXPECT_NEAR(go({1e-4, 0, -0.001})[0], -0.05, 1e-6) << "0.1 mm of the spring";
  EXPECT_NEAR(go({0.005, 0, -0.001})[0], -0.25, 1e-3) << "half of the 0.5 N that press";
}

TEST_F(LocalRendererTest, DampingResistsTheWayInAndNeverPulls) {
  const double undamped = go({0, 0, -0.001})[2];
  for (int k = 0; k < 50; ++k) tick(place);
  model.damping = 1.0;
  EXPECT_NEAR(tick(place)[2], undamped, 1e-4);
  const double in = go({0, 0, -0.003})[2];
  EXPECT_NEAR(in, 1.5 + 0.1, 0.01) << "1 N s/m at 0.1 m/s";
  double least = in;
  for (double z = -0.003; z < 0.001; z += 1e-4) least = std::min(least, tick({0, 0, z})[2]);
  EXPECT_GE(least, 0.0);
}

TEST_F(LocalRendererTest, WhatIsStifferThanTheDeviceKeepsPassiveIsSofter) {
  model.stiffness = 1e5;
  EXPECT_NEAR(go({0, 0, -0.001})[2], 2.0, 1e-9) << "2 b / T = 2000 N/m";
}

TEST_F(LocalRendererTest, BeginsAnewWithoutAForce) {
  go({0, 0, -0.001});
  EXPECT_EQ(vectors::norm(tick({0, kNan, -0.001})), 0.0);
  EXPECT_EQ(vectors::norm(tick({0, 0, -0.001})), 0.0) << "after no position";
  EXPECT_EQ(go({0, 0, -0.001})[2], 0.0) << "still";
  go({0, 0, 0.001});
  EXPECT_GT(go({0, 0, -0.001})[2], 0.4);
  EXPECT_EQ(vectors::norm(tick({0, 0, -0.1})), 0.0) << "after a jump";
  place = {0, 0, 0.001};
  tick(place);
  EXPECT_GT(go({0, 0, -0.001})[2], 0.4);
  now += 0.06;
  EXPECT_EQ(vectors::norm(tick(place)), 0.0) << "after a silence";
}

TEST_F(LocalRendererTest, TakesNothingFromTheHeap) {
  const palpate::test::AllocationGuard guard;
  go({0, 0, -0.001});
  EXPECT_EQ(guard.count(), 0U);
}

/// A hand and a network that do what they like.
class Chaos {
 public:
  explicit Chaos(unsigned seed) : random_(seed) {}

  LocalModel model(const Vector& about) {
    LocalModel made;
    made.count = static_cast<std::size_t>(uniform(0.0, 4.99));
    for (std::size_t k = 0; k < made.count; ++k) {
      Vector normal{normal_(random_), normal_(random_), normal_(random_)};
      normal = vectors::scaled(normal, 1.0 / vectors::norm(normal));
      made.planes[k] = {vectors::sum(about, normal, uniform(-0.005, 0.005)), normal};
    }
    made.stiffness = std::pow(10.0, uniform(0.0, 5.0));
    made.damping = uniform(0.0, 5.0);
    made.friction = uniform(0.0, 2.0);
    made.share = uniform(0.0, 1.0);
    return made;
  }
  /// Of a hand that draws what it can out of `force`, or moves at random.
  Vector way(const Vector& force) {
    const double size = std::pow(10.0, uniform(-7.0, -3.0));
    if (uniform(0.0, 1.0) < 0.5) return vectors::scaled(force, size);
    return {size * normal_(random_), size * normal_(random_), size * normal_(random_)};
  }
  double uniform(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

// What comes out is never more than the device absorbs, whatever models come.
TEST(TheEnergyOfALocalRenderer, IsNoMoreThanTheDeviceAbsorbs) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Chaos chaos(seed);
    LocalRenderer renderer({kRenderedForceMax, 0.0, kDamping});
    LocalModel model = chaos.model({});
    Vector position{}, force{};
    double now = 1.0, out = 0.0, absorbed = 0.0;
    for (int k = 0; k < 5000; ++k) {
      if (chaos.uniform(0.0, 1.0) < 0.1) model = chaos.model(position);
      const Vector way = chaos.way(force);
      out += vectors::dot(force, way);
      absorbed += kDamping * vectors::dot(way, way) / kPeriod;
      position = vectors::sum(position, way);
      now += kPeriod;
      force = renderer.ask(model, position, now);
      ASSERT_TRUE(vectors::is_finite(force));
      ASSERT_LE(vectors::norm(force), renderer.most() * (1.0 + 1e-12));
      force = vectors::scaled(vectors::clamped(force, kRenderedForceMax), chaos.uniform(0.0, 1.0));  // a gate
      renderer.show(force);
      ASSERT_LE(out, absorbed + 1e-9) << "seed " << seed << ", tick " << k;
    }
    EXPECT_GT(absorbed, 0.0);
  }
}

// A call that is late lets more out than the formula knows: then there is no force until that is paid back.
TEST(TheEnergyOfALocalRenderer, OfALateCallIsADebt) {
  LocalRenderer renderer({kRenderedForceMax, 0.0, kDamping});
  const LocalModel model = floor_at(0.0, 2000.0);
  double now = 1.0, z = 0.0;
  Vector force{};
  const auto call = [&](double to, double dt) {
    z = to;
    now += dt;
    force = renderer.ask(model, {0, 0, z}, now);
    renderer.show(force);
    return force[2];
  };
  call(0.0, kPeriod);
  for (int k = 1; k <= 10; ++k) call(-1e-4 * k, kPeriod);
  ASSERT_NEAR(force[2], 2.0, 1e-9);
  // 2 N over 4 mm are 8 mJ; 1 mJ was stored, and 1 N s/m absorbs 0.8 mJ of that in 20 ms.
  EXPECT_EQ(call(0.003, 0.02), 0.0);
  EXPECT_NEAR(renderer.energy(), -6.2e-3, 1e-6);
  EXPECT_EQ(call(-0.001, 0.02), 0.0) << "it owes 5.4 mJ";
  for (int k = 0; k < 20; ++k) call(k % 2 == 0 ? 0.002 : 0.001, kPeriod);
  EXPECT_EQ(renderer.energy(), 0.0) << "paid by what the device has absorbed";
  for (int k = 10; k >= -10; --k) call(1e-4 * k, kPeriod);
  EXPECT_NEAR(force[2], 2.0, 1e-9);
}

class LocalModelInTheGovernor : public testing::Test {
 protected:
  static constexpr double kDeep = 3e-3, kForce = 1.5;  // m, N

  double tick(double z, bool comes = true) {
    now += kPeriod;
    if (comes) {
      model.position = {0, 0, z};
      governor.take(Wrench{{0, 0, wrench}, {}}, now - late, now);
      governor.take_model(model, now - late, now);
    }
    return governor.show(Vector{0, 0, z}, now).force[2];
  }
  /// Through the gate, down to 3 mm under the floor.
  void press() {
    for (int k = 0; k < 150; ++k) tick(1e-3);
    for (int k = 10; k >= -30; --k) tick(1e-4 * k);
    ASSERT_NEAR(tick(-kDeep), kForce, 1e-9);
  }

  double now = 100.0, late = 0.0, wrench = 7.0;
  LocalModel model = floor_at(0.0);
  WrenchGovernor governor{{kRenderedForceMax, 0.0, kDamping}};
};

TEST_F(LocalModelInTheGovernor, IsShownInPlaceOfTheForce) { press(); }

TEST_F(LocalModelInTheGovernor, IsShownLaterThanAForceWouldBe) {
  late = 0.08;
  press();
}

TEST_F(LocalModelInTheGovernor, EndsFiftyMillisecondsAfterTheLastOne) {
  press();
  for (int k = 1; k <= 44; ++k) EXPECT_NEAR(tick(-kDeep, false), kForce, 1e-9) << k;
  for (int k = 45; k <= 49; ++k) EXPECT_LE(tick(-kDeep, false), kForce);
  EXPECT_EQ(tick(-kDeep, false), 0.0);
  for (int k = 0; k < 300; ++k) EXPECT_EQ(tick(-kDeep), 0.0) << "pressed, no gate opens";
  press();
}

TEST_F(LocalModelInTheGovernor, EndsWhereThePoseThatItAnswersIsTooOld) {
  press();
  for (late = 0.0; late < 0.094; late += kPeriod) EXPECT_NEAR(tick(-kDeep), kForce, 1e-9);
  for (int k = 0; k < 8; ++k, late += kPeriod) tick(-kDeep);
  EXPECT_EQ(tick(-kDeep), 0.0);
}

TEST_F(LocalModelInTheGovernor, EndsFarFromWhereItWasMade) {
  press();
  model.position = {0, 0, 0.0078};
  const auto shown = [&] {
    now += kPeriod;
    governor.take_model(model, now, now);
    return governor.show(Vector{0, 0, -kDeep}, now).force[2];
  };
  for (int k = 0; k < 5; ++k) shown();
  EXPECT_EQ(shown(), 0.0) << "10.8 mm";
}

TEST_F(LocalModelInTheGovernor, ThatIsNoneEndsInZero) {
  const auto with = [](auto&& change) {
    LocalModel bad = floor_at(0.0);
    change(bad);
    return bad;
  };
  const std::array bad{with([](LocalModel& m) {
                         m.planes[0].normal = {0, 0, 2};
                       }),
                       with([](LocalModel& m) { m.planes[0].point[1] = kNan; }),
                       with([](LocalModel& m) { m.planes[0].point[2] = 1.7e308; }),
                       with([](LocalModel& m) { m.position[0] = kNan; }),
                       with([](LocalModel& m) { m.count = LocalModel::kMost + 1; }),
                       with([](LocalModel& m) { m.stiffness = -1.0; }),
                       with([](LocalModel& m) { m.damping = kNan; }),
                       with([](LocalModel& m) { m.friction = -0.1; }),
                       with([](LocalModel& m) { m.share = 1.1; })};
  for (const LocalModel& none : bad) {
    press();
    governor.take_model(none, now, now);
    for (int k = 0; k < 5; ++k) tick(-kDeep, false);
    EXPECT_EQ(tick(-kDeep), 0.0);
    for (int k = 0; k < 10; ++k) tick(0.0);
  }
}

// The program feels nothing for a moment after a loss, and a model of then has neither planes nor a share.
TEST_F(LocalModelInTheGovernor, OpensNoGateForAModelWithoutAShare) {
  press();
  for (int k = 0; k < 60; ++k) tick(-kDeep, false);
  model.count = 0;
  model.share = 0.0;
  for (int k = 0; k < 100; ++k) EXPECT_EQ(tick(-kDeep), 0.0);
  model = floor_at(0.0);
  for (int k = 0; k < 300; ++k) EXPECT_EQ(tick(-kDeep + k % 2 * 1e-4), 0.0);
  press();
}

TEST_F(LocalModelInTheGovernor, EndsWhereTheHandleIsNowhere) {
  press();
  now += kPeriod;
  EXPECT_EQ(vectors::norm(governor.show(Vector{0, kNan, -kDeep}, now).force), 0.0);
  for (int k = 0; k < 5; ++k) tick(-kDeep);
  for (int k = 0; k < 300; ++k) EXPECT_EQ(tick(-kDeep + k % 2 * 1e-4), 0.0);
  press();
}

TEST_F(LocalModelInTheGovernor, OfAModelWithoutOneTheWrenchIsShown) {
  model.stiffness = 0.0;
  for (int k = 0; k < 150; ++k) {
    now += kPeriod;
    governor.take_model(model, now, now);
    governor.take(Wrench{}, now, now);
    governor.show(Vector{}, now);
  }
  EXPECT_NEAR(tick(-kDeep), 7.0, 1e-9);
}

// The force model of the program is changed while the hand presses.
TEST_F(LocalModelInTheGovernor, GivesWayToTheWrenchAndBackWithoutAStep) {
  wrench = 0.0;
  press();
  wrench = 7.0;
  double last = kForce;
  const auto change = [&](double largest) {
    for (int k = 0; k < 20; ++k) {
      const double shown = tick(-kDeep);
      EXPECT_LE(std::abs(shown - last), largest + 1e-9) << k;
      last = shown;
    }
  };
  model.stiffness = 0.0;
  change(kRenderedForceMax * kPeriod / LocalRenderer::kSlewTime);
  EXPECT_NEAR(last, 7.0, 1e-9);
  model.stiffness = kStiffness;
  change(7.0 * kPeriod / WrenchGovernor::kFall);
  EXPECT_EQ(last, 0.0) << "pressed, no gate opens";
  press();
}

// What is shown of the wrench while the sources change still ends with the wrench.
TEST_F(LocalModelInTheGovernor, GivesWayToNoWrenchThatIsLost) {
  wrench = 0.0;
  press();
  wrench = 7.0;
  model.stiffness = 0.0;
  tick(-kDeep);
  governor.fail();
  for (int k = 0; k < 5; ++k) tick(-kDeep, false);
  EXPECT_EQ(tick(-kDeep, false), 0.0);
}

}  // namespace
}  // namespace palpate_client

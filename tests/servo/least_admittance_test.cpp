// The bounds of stability against closed forms and against simulations that know nothing of them.
#include <palpate/servo/least_admittance.h>

#include <cmath>
#include <deque>
#include <numbers>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>

namespace palpate {
namespace {

/// The loop of is_stable() as differential equations, in steps of 20 us. \returns how much larger its swing
/// is after two seconds than after one.
double growth(const AxisAdmittance& a, const AdmittanceLoopModel& l) {
  constexpr double h = 2e-5;
  const auto late = static_cast<std::size_t>(std::lround(l.delay / h));
  std::deque<double> past(late + 1, 0.0);
  double x = 1e-3, v = 0.0, drive = x, link = x, link_v = 0.0, sensed = 0.0, before_v = 0.0, early = 0.0,
         end = 0.0;
  for (double& p : past) p = x;
  for (int k = 0; k * h < 3.0; ++k) {
    past.push_back(x);
    past.pop_front();
    const double shown = past.front();
    const double rate = l.lag > 0.0 ? (shown - drive) / l.lag : 0.0;
    drive = l.lag > 0.0 ? drive + h * rate : shown;
    if (l.resonance > 0.0) {
      const double w = l.resonance;
      link_v += h * (w * w * (drive - link) + 2.0 * l.resonance_damping * w * (rate - link_v));
    } else {
      link_v = (drive - link) / h;
    }
    link += h * link_v;
    const double hand =
        -l.hand_stiffness * link - l.hand_damping * link_v - l.hand_mass * (link_v - before_v) / h;
    before_v = link_v;
    sensed = l.sensor_lag > 0.0 ? sensed + h / l.sensor_lag * (hand - sensed) : hand;
    const double force = sensed - l.contact_stiffness * link - l.contact_damping * link_v;
    v += h * (force - a.damping * v) / a.mass;
    x += h * v;
    if (!(std::abs(x) < 1e6)) return 1e9;
    const double t = k * h;
    if (t > 0.5 && t < 1.0) early = std::max(early, std::abs(x));
    if (t > 2.5) end = std::max(end, std::abs(x));
  }
  return end / early;
}

double measured_damping(double mass, const AdmittanceLoopModel& l) {
  double low = 0.01, high = 1e4;
  for (int k = 0; k < 24; ++k) {
    const double middle = std::sqrt(low * high);
    (growth({mass, middle}, l) < 1.0 ? high : low) = middle;
  }
  return high;
}

/// Where `below` ends to be true, between `low` and `high`.
template <class Below>
double end_of(double low, double high, Below below) {
  for (int k = 0; k < 200; ++k) {
    const double middle = 0.5 * (low + high);
    (below(middle) ? low : high) = middle;
  }
  return high;
}

// On the bound s = j w: K cos(w tau) = M w^2 and K sin(w tau) = D w.
TEST(LeastAdmittance, IsTheClosedFormWhereThatIsKnown) {
  for (const double mass : {0.5, 3.0, 20.0})
    for (const double delay : {1e-3, 5e-3, 20e-3}) {
      AdmittanceLoopModel loop;
      loop.contact_stiffness = 2000.0;
      loop.delay = delay;
      const double w = end_of(0.0, 0.5 * std::numbers::pi / delay,
                              [&](double at) { return 2000.0 * std::cos(at * delay) > mass * at * at; });
      const double damping = 2000.0 * std::sin(w * delay) / w;
      EXPECT_NEAR(least_damping(mass, loop, 1.0), damping, 1e-3 * damping) << mass << ", " << delay;
    }
}

// M s + D + B exp(-s tau) = 0 on the bound: D = -B cos(w tau) and M w = B sin(w tau).
TEST(LeastAdmittance, IsTheClosedFormOfADamperThatIsLate) {
  for (const double mass : {0.1, 0.5, 2.0})
    for (const double delay : {1e-4, 1e-3, 5e-3}) {
      AdmittanceLoopModel loop;
      loop.contact_damping = 4.0 * mass / delay;
      loop.delay = delay;
      const double quarter = 0.5 * std::numbers::pi / delay;
      const double w = end_of(quarter, 2.0 * quarter, [&](double at) {
        return loop.contact_damping * std::sin(at * delay) > mass * at;
      });
      const double damping = -loop.contact_damping * std::cos(w * delay);
      ASSERT_GT(damping, 0.0);
      EXPECT_NEAR(least_damping(mass, loop, 1.0), damping, 1e-3 * damping) << mass << ", " << delay;
    }
}

// Without a delay or a lag, s (M s + D) (1 + 2 z s / w + s^2 / w^2) + K (1 + 2 z s / w) is of degree 4:
// Hurwitz has the bound.
TEST(LeastAdmittance, IsThatOfHurwitzForAResonance) {
  const double M = 2.0, K = 3000.0;
  for (const double w : {60.0, 150.0})
    for (const double z : {0.02, 0.1, 0.3}) {
      const auto stable = [&](double D) {
        const double a4 = M / (w * w), a3 = D / (w * w) + 2.0 * z * M / w, a2 = M + 2.0 * z * D / w,
                     a1 = D + 2.0 * z * K / w;
        return a3 * a2 * a1 > a4 * a1 * a1 + a3 * a3 * K;
      };
      if (stable(0.0)) continue;
      const double least = end_of(0.0, 1e5, [&](double D) { return !stable(D); });
      AdmittanceLoopModel loop;
      loop.contact_stiffness = K;
      loop.resonance = w;
      loop.resonance_damping = z;
      EXPECT_NEAR(least_damping(M, loop, 1.0), least, 2e-3 * least) << w << ", " << z;
    }
}

// The lag of the sensor filters what the hand's mass does, of which more than the virtual one would be too
// much.
TEST(LeastAdmittance, ASensorWithALagBearsAHandOfGreaterMass) {
  AdmittanceLoopModel loop;
  loop.hand_mass = 0.3;
  loop.hand_stiffness = 500.0;
  loop.hand_damping = 5.0;
  loop.sensor_lag = 5e-3;
  // (M + D T + m) (D + b) > M T k
  EXPECT_TRUE(is_stable({0.2, 5.0}, loop));
  std::swap(loop.sensor_lag, loop.lag);
  EXPECT_TRUE(is_stable({0.2, 5.0}, loop));
  loop.lag = 0.0;
  EXPECT_FALSE(is_stable({0.2, 5.0}, loop));
}

TEST(LeastAdmittance, NeedsNothingWhereNothingIsLate) {
  AdmittanceLoopModel loop;
  loop.contact_stiffness = 5000.0;
  EXPECT_LT(least_damping(1.0, loop, 1.0), 1e-3);
  EXPECT_TRUE(is_stable({1.0, 0.1}, loop));
}

TEST(LeastAdmittance, OfAHandOfGreaterMassThanTheVirtualOneIsUnstableWithoutLags) {
  AdmittanceLoopModel loop;
  loop.hand_mass = 0.3;
  loop.hand_stiffness = 500.0;
  loop.hand_damping = 5.0;
  loop.delay = 1e-3;
  EXPECT_FALSE(is_stable({0.29, 5.0}, loop));
  EXPECT_TRUE(is_stable({0.5, 5.0}, loop));
}

TEST(LeastAdmittance, IsWhatSimulationsMeasure) {
  for (const double stiffness : {200.0, 1000.0, 5000.0})
    for (const double delay : {0.5e-3, 5e-3, 10e-3}) {
      AdmittanceLoopModel loop;
      loop.contact_stiffness = stiffness;
      loop.hand_mass = 0.1;
      loop.hand_damping = 3.0;
      loop.hand_stiffness = 200.0;
      loop.delay = delay;
      loop.lag = 5e-3;
      loop.sensor_lag = 2e-3;
      loop.resonance = 250.0;
      loop.resonance_damping = 0.2;
      const double predicted = least_damping(2.0, loop, 1.0);
      EXPECT_NEAR(measured_damping(2.0, loop), predicted, 0.03 * predicted + 0.05)
          << stiffness << ", " << delay;
    }
}

TEST(LeastAdmittance, IsOnTheBound) {
  AdmittanceLoopModel loop;
  loop.contact_stiffness = 1000.0;
  loop.hand_mass = 0.3;
  loop.hand_damping = 3.0;
  loop.hand_stiffness = 500.0;
  loop.delay = 4e-3;
  loop.lag = 5e-3;
  const AxisAdmittance least = least_admittance(loop);
  EXPECT_NO_THROW(require_stable(least, loop, "along x", kDesignMargin));
  EXPECT_GE(gain_margin(least, loop), kDesignMargin * (1 - 1e-6));
  EXPECT_THROW(require_stable({least.mass, 0.97 * least.damping}, loop, "along x", kDesignMargin), Error);
  AdmittanceLoopModel worse = loop;
  worse.contact_stiffness = 3000.0;
  const auto felt = [](const AxisAdmittance& a) { return std::hypot(kFreeMotion * a.mass, a.damping); };
  EXPECT_GT(felt(least_admittance(worse)), felt(least));
}

TEST(LeastAdmittance, SaysWhichBoundIsBroken) {
  AdmittanceLoopModel loop;
  loop.contact_stiffness = 5000.0;
  loop.delay = 10e-3;
  loop.lag = 5e-3;
  try {
    require_stable({1.5, 10.0}, loop, "along z");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                testing::AllOf(testing::HasSubstr("along z"), testing::HasSubstr("5000 N/m"),
                               testing::HasSubstr("10 ms"), testing::HasSubstr("damping of 1")));
  }
  EXPECT_THROW(require_stable({0.0, 10.0}, {}, "x"), Error);
  EXPECT_THROW(require_stable({1.0, -1.0}, {}, "x"), Error);
}

}  // namespace
}  // namespace palpate

// K by hand, K at a given lambda against 113-bit arithmetic, and what must hold of any K.

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <palpate/collision/k_function.h>
#include <support/k_oracle.h>
#include <support/random_pairs.h>
#include <support/solids.h>

namespace palpate {
namespace {

using test::ball;
using test::ellipsoid;
using test::Pair;
using test::PairOracle;
using test::Quad;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

KFunction k_of(const Ellipsoid& tool, const Ellipsoid& gaussian) { return {WhitenedTool(tool), gaussian}; }
KMinimum minimum_of(const Ellipsoid& tool, const Ellipsoid& gaussian) {
  return minimize(k_of(tool, gaussian));
}

/// A pair that may or may not overlap.
Pair random_pair(test::Random& r) {
  const Ellipsoid tool = r.ellipsoid(1.0, 0.02, 0.2);
  const Pose pose{tool.center, r.rotation()};
  Ellipsoid gaussian = Ellipsoid::from_semi_axes(pose, r.semi_axes(0.001, 0.3));
  const double apart = r.uniform(0.5, 1.3);
  const Eigen::Vector3d on_gaussian = gaussian.axes * r.direction(), on_tool = tool.axes * r.direction();
  gaussian.center -= apart * (on_gaussian + on_tool);
  return {tool, gaussian};
}

// By hand. Two balls: [(1-l) r_t^2 + l r_g^2]^-1 is a number, and 1 - K = |d|^2 l(1-l) / ((1-l) r_t^2 +
// l r_g^2). Its derivative vanishes where (1-l) r_t = l r_g, that is at l = r_t / (r_t + r_g), and there
// 1 - K = |d|^2 / (r_t + r_g)^2.
TEST(KFunction, OfTwoBallsIsTheSquareOfTheirDistance) {
  const KFunction k = k_of(ball({0, 0, 0}, 3.0), ball({1, 2, 2}, 1.0));  // |d| = 3
  EXPECT_NEAR(k.p0, 1.0, 1e-15);                                         // (3/3)^2
  EXPECT_NEAR(k(0.5), 1.0 - 9.0 * 0.25 / 5.0, 1e-15);                    // (9 + 1) / 2 = 5
  EXPECT_NEAR(k(0.25), 1.0 - 9.0 * 0.1875 / 7.0, 1e-15);                 // 0.75 * 9 + 0.25 * 1 = 7
  const KMinimum minimum = minimize(k);
  EXPECT_NEAR(minimum.k_min, 1.0 - 9.0 / 16.0, 1e-15);
  EXPECT_NEAR(minimum.lambda, 0.75, 1e-8);
  EXPECT_NEAR(minimum.log_t, std::log(3.0), 1e-8);
}

TEST(KFunction, OfBallsOfAnySizeRatio) {
  for (const double ratio : {1e-8, 1e-5, 1e-2, 1.0, 1e2, 1e5, 1e8}) {
    for (const double gap : {0.5, 1.0, 3.0}) {  // |d| / (r_t + r_g)
      const KMinimum minimum = minimum_of(ball({0, 0, 0}, 1.0), ball({0, gap * (1.0 + ratio), 0}, ratio));
      EXPECT_NEAR(minimum.k_min, 1.0 - gap * gap, 1e-14 * std::max(1.0, gap * gap)) << ratio;
      // ln(1-K) bends by l(1-l) in ln t; the more it is flat, the less its minimum is a place.
      const double tolerance = 1e-8 + 1e-15 * std::max(ratio, 1.0 / ratio);
      EXPECT_NEAR(minimum.log_t, -std::log(ratio), tolerance) << ratio;
      EXPECT_NEAR(minimum.lambda * (1.0 + ratio), 1.0, tolerance) << ratio;
    }
  }
}

// Numbers for which the doubles of the input are exact: 3-4-5 triangles and powers of two.
TEST(KFunction, IsZeroWhereSolidsTouch) {
  EXPECT_NEAR(minimum_of(ball({0, 0, 0}, 0.5), ball({0.75, 0, 0}, 0.25)).k_min, 0.0, 1e-15);
  EXPECT_NEAR(minimum_of(ball({0, 0, 0}, 0.5), ball({0.375, 0.5, 0}, 0.125)).k_min, 0.0, 1e-15);
  // Aligned ellipsoids whose tips meet on the x axis.
  EXPECT_NEAR(minimum_of(ellipsoid({0, 0, 0}, {2, 1, 0.5}), ellipsoid({5, 0, 0}, {3, 0.25, 4})).k_min, 0.0,
              1e-15);
  // A ball on the face of a disc, beside a needle, on the tip of a needle, at a point.
  EXPECT_NEAR(minimum_of(ball({0.25, 0.5, 1}, 1.0), ellipsoid({0, 0, 0}, {4, 4, 0})).k_min, 0.0, 1e-15);
  EXPECT_NEAR(minimum_of(ball({0.5, 0, 1}, 1.0), ellipsoid({0, 0, 0}, {4, 0, 0})).k_min, 0.0, 1e-15);
  EXPECT_NEAR(minimum_of(ball({5, 0, 0}, 1.0), ellipsoid({0, 0, 0}, {4, 0, 0})).k_min, 0.0, 1e-15);
  EXPECT_NEAR(minimum_of(ball({3, 4, 0}, 5.0), ellipsoid({0, 0, 0}, {0, 0, 0})).k_min, 0.0, 1e-15);
}

// Along a common axis of two aligned ellipsoids, a and b their semi-axes on it: as two balls.
TEST(KFunction, OfAlignedEllipsoidsAlongAnAxis) {
  const Ellipsoid tool = ellipsoid({0, 0, 0}, {0.5, 2.0, 0.1});
  const Eigen::Vector3d axes(0.25, 0.125, 3.0);
  for (int axis = 0; axis < 3; ++axis) {
    const double a = tool.axes(axis, axis), b = axes[axis];
    for (const double distance : {0.3 * (a + b), 0.9 * (a + b), 1.5 * (a + b)}) {
      const KMinimum minimum = minimum_of(tool, ellipsoid(distance * Eigen::Vector3d::Unit(axis), axes));
      EXPECT_NEAR(minimum.k_min, 1.0 - distance * distance / ((a + b) * (a + b)), 1e-14);
      EXPECT_NEAR(minimum.lambda, a / (a + b), 1e-8);
    }
  }
}

/// Distance from `p` to the flat ellipse { (a cos u, b sin u, 0) } and its inside, by search.
double distance_to_disc(const Eigen::Vector3d& p, double a, double b) {
  if (p.x() * p.x() / (a * a) + p.y() * p.y() / (b * b) <= 1.0) return std::abs(p.z());
  const auto at = [&](double u) {
    return (p - Eigen::Vector3d(a * std::cos(u), b * std::sin(u), 0.0)).norm();
  };
  constexpr int kSamples = 2000;
  double best = 0.0;
  for (int i = 1; i < kSamples; ++i)
    if (at(2 * M_PI * i / kSamples) < at(best)) best = 2 * M_PI * i / kSamples;
  for (double step = 2 * M_PI / kSamples; step > 1e-12; step *= 0.5)
    for (const double u : {best - step, best + step})
      if (at(u) < at(best)) best = u;
  return at(best);
}

// Geometry alone says whether a ball meets a disc or a needle: its radius against their distance.
TEST(KFunction, VerdictOnBallAndDiscIsTheirDistance) {
  test::Random random(31);
  int overlapping = 0;
  for (int i = 0; i < 2000; ++i) {
    const double a = random.log_uniform(0.1, 2.0), b = i % 4 == 0 ? 0.0 : random.log_uniform(0.01, 1.0);
    const Eigen::Vector3d p = random.in_box(2.0);
    const Eigen::Vector3d on_needle(std::clamp(p.x(), -a, a), 0.0, 0.0);
    const double distance = b > 0.0 ? distance_to_disc(p, a, b) : (p - on_needle).norm();
    for (const double factor : {0.5, 0.999999, 1.000001, 2.0}) {
      const double k_min = minimum_of(ball(p, factor * distance), ellipsoid({0, 0, 0}, {a, b, 0.0})).k_min;
      EXPECT_EQ(k_min > 0.0, factor > 1.0) << "k_min " << k_min << " pair " << i;
      overlapping += k_min > 0.0;
    }
  }
  EXPECT_EQ(overlapping, 4000);
}

// Over the face of a disc K is 1 - (height / radius)^2, whatever the disc.
TEST(KFunction, OverTheFaceOfADisc) {
  const KMinimum minimum = minimum_of(ball({0.5, -0.25, 0.5}, 2.0), ellipsoid({0, 0, 0}, {64, 32, 0}));
  EXPECT_NEAR(minimum.k_min, 1.0 - 0.0625, 1e-15);
}

TEST(KFunction, IsOneAtBothEnds) {
  test::Random random(32);
  for (int i = 0; i < 100; ++i) {
    const Pair pair = random_pair(random);
    const KFunction k = k_of(pair.tool, pair.gaussian);
    EXPECT_EQ(k(0.0), 1.0);
    EXPECT_NEAR(k(1.0), 1.0, 1e-15);
  }
}

TEST(KFunction, AgreesWithQuadruplePrecisionAtAnyLambda) {
  test::Random random(33);
  double worst = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const Pair pair = random_pair(random);
    const KFunction k = k_of(pair.tool, pair.gaussian);
    const PairOracle<Quad> oracle(pair.tool, pair.gaussian);
    const double tiny = random.log_uniform(1e-15, 1e-2);
    for (const double lambda : {random.uniform(0.0, 1.0), tiny, 1.0 - tiny, 0.5}) {
      const Quad truth = oracle.k_at_lambda(lambda);
      const double error = std::abs(static_cast<double>(k(lambda) - truth));
      worst = std::max(worst, error / std::max(1.0, static_cast<double>(1 - truth)));
    }
  }
  RecordProperty("worst_dk", testing::PrintToString(worst));
  EXPECT_LE(worst, 1e-13);
}

TEST(KFunction, IsConvex) {
  test::Random random(34);
  for (int i = 0; i < 500; ++i) {
    const Pair pair = random_pair(random);
    const KFunction k = k_of(pair.tool, pair.gaussian);
    const KMinimum minimum = minimize(k);
    constexpr int kSteps = 64;
    for (int j = 1; j < kSteps; ++j) {
      const double step = 1.0 / kSteps, lambda = j * step;
      const double bend = k(lambda - step) - 2.0 * k(lambda) + k(lambda + step);
      EXPECT_GE(bend, -1e-14 * (1.0 + std::abs(minimum.k_min)));
      EXPECT_GE(k(lambda), minimum.k_min - 1e-14 * (1.0 + std::abs(minimum.k_min)));
    }
  }
}

// The solver of contact geometry: (I + t L L^T) y = d'.
TEST(KFunction, SolveWhitenedSolves) {
  test::Random random(35);
  for (int i = 0; i < 500; ++i) {
    Pair pair = random_pair(random);
    if (i % 3 == 0) pair.gaussian.axes.col(i % 2).setZero();
    const KFunction k = k_of(pair.tool, pair.gaussian);
    for (const double log_t : {-30.0, -3.0, 0.0, 1e-9, 3.0, random.uniform(-6.0, 6.0)}) {
      const Eigen::Vector3d y = solve_whitened(k, log_t);
      const Eigen::Vector3d back = y + std::exp(log_t) * (k.L * (k.L.transpose() * y));
      EXPECT_LE((back - k.d).norm(), 1e-11 * k.d.norm()) << log_t;
    }
  }
}

// What a change of frame, unit or roles does to the minimum: nothing, or something known.

TEST(KFunctionInvariance, RigidMotion) {
  test::Random random(36);
  for (int i = 0; i < 500; ++i) {
    const Pair pair = random_pair(random);
    const Eigen::Matrix3d R = random.rotation().toRotationMatrix();
    const Eigen::Vector3d t = random.in_box(10.0);
    const auto moved = [&](const Ellipsoid& e) -> Ellipsoid { return {R * e.center + t, R * e.axes}; };
    const KMinimum before = minimum_of(pair.tool, pair.gaussian);
    const KMinimum after = minimum_of(moved(pair.tool), moved(pair.gaussian));
    // Centres are rounded at 10 m: 1e-15 m, over semi-axes of 1 mm and more.
    EXPECT_NEAR(after.k_min, before.k_min, 1e-12 * std::max(1.0, 1.0 - before.k_min));
  }
}

TEST(KFunctionInvariance, UniformScale) {
  test::Random random(37);
  for (int i = 0; i < 500; ++i) {
    const Pair pair = random_pair(random);
    const double s = std::ldexp(1.0, random.integer(-40, 40));  // exact
    const auto scaled = [&](const Ellipsoid& e) -> Ellipsoid { return {s * e.center, s * e.axes}; };
    const KMinimum before = minimum_of(pair.tool, pair.gaussian);
    const KMinimum after = minimum_of(scaled(pair.tool), scaled(pair.gaussian));
    EXPECT_EQ(after.k_min, before.k_min);
    EXPECT_EQ(after.log_t, before.log_t);
  }
}

TEST(KFunctionInvariance, TheOrderOfAxesAndTheirSigns) {
  test::Random random(38);
  for (int i = 0; i < 200; ++i) {
    const Pair pair = random_pair(random);
    const double before = minimum_of(pair.tool, pair.gaussian).k_min;
    Ellipsoid shuffled = pair.gaussian;
    shuffled.axes.col(0) = -pair.gaussian.axes.col(2);
    shuffled.axes.col(1) = pair.gaussian.axes.col(0);
    shuffled.axes.col(2) = pair.gaussian.axes.col(1);
    EXPECT_NEAR(minimum_of(pair.tool, shuffled).k_min, before, 1e-14 * std::max(1.0, 1.0 - before));
    Ellipsoid tool = pair.tool;
    tool.axes.col(1) *= -1.0;
    tool.axes.col(0).swap(tool.axes.col(2));
    EXPECT_NEAR(minimum_of(tool, pair.gaussian).k_min, before, 1e-14 * std::max(1.0, 1.0 - before));
  }
}

TEST(KFunctionInvariance, SwappingTheSolidsTurnsLambdaRound) {
  test::Random random(39);
  for (int i = 0; i < 500; ++i) {
    const Pair pair = random_pair(random);
    const KMinimum one = minimum_of(pair.tool, pair.gaussian);
    const KMinimum other = minimum_of(pair.gaussian, pair.tool);
    EXPECT_NEAR(other.k_min, one.k_min, 1e-12 * std::max(1.0, 1.0 - one.k_min));
    EXPECT_NEAR(other.log_t, -one.log_t, 1e-7);
    EXPECT_NEAR(other.lambda, 1.0 - one.lambda, 1e-7);
  }
}

TEST(KFunctionInvariance, OneMinusKGoesWithTheSquareOfTheDistance) {
  test::Random random(40);
  for (int i = 0; i < 200; ++i) {
    Pair pair = random_pair(random);
    pair.tool.center.setZero();
    const double before = 1.0 - minimum_of(pair.tool, pair.gaussian).k_min;
    for (const double factor : {1e-3, 0.5, 2.0, 1e6}) {
      Ellipsoid moved = pair.gaussian;
      moved.center *= factor;
      const double after = 1.0 - minimum_of(pair.tool, moved).k_min;
      EXPECT_NEAR(after, factor * factor * before, 1e-13 * std::max(1.0, after));
    }
  }
}

TEST(WhitenedTool, TurnsTheToolIntoTheUnitBall) {
  test::Random random(41);
  for (int i = 0; i < 100; ++i) {
    const Ellipsoid tool = random_pair(random).tool;
    const WhitenedTool whitened(tool);
    const Eigen::Matrix3d unit = whitened.W * tool.axes;
    EXPECT_LE((unit * unit.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-13);
  }
}

TEST(KMinimum, IsFiniteAtTheEdgeOfWhatScenesMayHold) {
  // kMaxExtent of the scene, and a tool of a micrometre.
  for (const double size : {1e12, 1e-300, 5e-324}) {
    for (const double distance : {1e12, 1.0, 1e-300, 5e-324}) {
      const KMinimum minimum = minimum_of(ball({distance, 0, 0}, 1e-6), ball({0, 0, 0}, size));
      EXPECT_TRUE(std::isfinite(minimum.k_min)) << size << " " << distance;
      EXPECT_TRUE(std::isfinite(minimum.log_t) && minimum.lambda >= 0.0 && minimum.lambda <= 1.0);
      if (distance != size) {  // else a double cannot tell
        EXPECT_EQ(minimum.k_min > 0.0, distance < size + 1e-6) << size << " " << distance;
      }
      EXPECT_LT(minimum.k_min, kInfinity);
    }
  }
}

}  // namespace
}  // namespace palpate

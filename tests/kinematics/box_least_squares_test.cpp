// The quadratic programme against all of its active sets, and against the conditions of its optimum.
#include <palpate/kinematics/box_least_squares.h>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <support/random_joints.h>

namespace palpate {
namespace {

BoxProblem random_problem(int n, std::mt19937_64& random) {
  BoxProblem p;
  JointMatrix A(n, n);
  p.g.resize(n);
  p.lower.resize(n);
  p.upper.resize(n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) A(i, j) = test::uniform(random, -1, 1);
    p.g[i] = test::uniform(random, -3, 3);
    p.lower[i] = test::uniform(random, -1, 0.5);
    p.upper[i] = random() % 8 == 0 ? p.lower[i] : p.lower[i] + test::uniform(random, 0, 1);
  }
  p.H = A.transpose() * A + 1e-3 * JointMatrix::Identity(n, n);
  return p;
}

double value(const BoxProblem& p, const JointVector& x) { return 0.5 * x.dot(p.H * x) - p.g.dot(x); }

/// Every variable free, at its lower or at its upper bound: 3^n systems, of which the best that is within the
/// bounds is the solution.
double best_of_all_sets(const BoxProblem& p) {
  const auto n = static_cast<int>(p.g.size());
  double best = std::numeric_limits<double>::infinity();
  for (int set = 0; set < std::lround(std::pow(3, n)); ++set) {
    JointMatrix H = p.H;
    JointVector g = p.g;
    for (int i = 0, rest = set; i < n; ++i, rest /= 3) {
      if (rest % 3 == 0) continue;
      H.row(i).setZero();
      H(i, i) = 1.0;
      g[i] = rest % 3 == 1 ? p.lower[i] : p.upper[i];
    }
    const JointVector x = Eigen::MatrixXd(H).fullPivLu().solve(Eigen::VectorXd(g));
    const bool inside = ((x - p.lower).array() >= -1e-12).all() && ((p.upper - x).array() >= -1e-12).all();
    if (inside) best = std::min(best, value(p, x));
  }
  return best;
}

TEST(BoxLeastSquares, IsTheBestOfAllActiveSets) {
  std::mt19937_64 random(5);
  for (int k = 0; k < 400; ++k) {
    const BoxProblem p = random_problem(1 + k % 5, random);
    const BoxSolution solution = least_in_box(p);
    ASSERT_TRUE(solution.optimal);
    ASSERT_NEAR(value(p, solution.x), best_of_all_sets(p), 1e-9);
  }
}

TEST(BoxLeastSquares, MeetsTheConditionsOfAnOptimum) {
  std::mt19937_64 random(6);
  for (int k = 0; k < 20000; ++k) {
    const BoxProblem p = random_problem(kMaxJoints, random);
    const BoxSolution s = least_in_box(p);
    ASSERT_TRUE(s.optimal) << k;
    const JointVector slope = p.H * s.x - p.g;
    for (int i = 0; i < kMaxJoints; ++i) {
      ASSERT_GE(s.x[i], p.lower[i]);
      ASSERT_LE(s.x[i], p.upper[i]);
      if (p.lower[i] == p.upper[i]) continue;
      ASSERT_TRUE(s.x[i] == p.lower[i] || slope[i] <= 1e-9);
      ASSERT_TRUE(s.x[i] == p.upper[i] || slope[i] >= -1e-9);
    }
  }
}

TEST(BoxLeastSquares, StaysWithinTheBoundsOfWhatIsNotFinite) {
  std::mt19937_64 random(7);
  BoxProblem p = random_problem(4, random);
  p.g[2] = std::numeric_limits<double>::quiet_NaN();
  const BoxSolution s = least_in_box(p);
  EXPECT_FALSE(s.optimal);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(s.x[i] >= p.lower[i] && s.x[i] <= p.upper[i]);
}

}  // namespace
}  // namespace palpate

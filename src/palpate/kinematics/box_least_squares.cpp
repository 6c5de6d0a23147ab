#include <palpate/kinematics/box_least_squares.h>

#include <algorithm>
#include <array>

#include <Eigen/Cholesky>

namespace palpate {
namespace {

constexpr int kMaxChanges = 8 * kMaxJoints;
/// Rounding error of a multiplier, relative to the sum of the magnitudes of its terms.
constexpr double kRounding = 1e-12;

enum class Held : signed char { kNo, kLower, kUpper };
using HeldVector = std::array<Held, kMaxJoints>;

/// Minimum over the free variables, with the held ones fixed at x.
JointVector least_of_free(const BoxProblem& p, const JointVector& x, const HeldVector& held) {
  const auto n = static_cast<int>(x.size());
  std::array<int, kMaxJoints> index{};
  int count = 0;
  for (int i = 0; i < n; ++i)
    if (held[static_cast<std::size_t>(i)] == Held::kNo) index[static_cast<std::size_t>(count++)] = i;
  JointMatrix H(count, count);
  JointVector g(count);
  for (int a = 0; a < count; ++a) {
    const int i = index[static_cast<std::size_t>(a)];
    g[a] = p.g[i];
    for (int j = 0; j < n; ++j)
      if (held[static_cast<std::size_t>(j)] != Held::kNo) g[a] -= p.H(i, j) * x[j];
    for (int b = 0; b < count; ++b) H(a, b) = p.H(i, index[static_cast<std::size_t>(b)]);
  }
  const JointVector free = H.llt().solve(g);
  JointVector whole = x;
  for (int a = 0; a < count; ++a) whole[index[static_cast<std::size_t>(a)]] = free[a];
  return whole;
}

/// Moves x towards `to`, up to the first bound. \returns true if a bound was met, which is then active.
bool step_to_bound(const BoxProblem& p, JointVector& x, const JointVector& to, HeldVector& held) {
  double share = 1.0;
  int first = -1;
  for (int i = 0; i < x.size(); ++i) {
    if (held[static_cast<std::size_t>(i)] != Held::kNo) continue;
    const double bound = to[i] > x[i] ? p.upper[i] : p.lower[i];
    const bool beyond = to[i] > p.upper[i] || to[i] < p.lower[i];
    if (!beyond) continue;
    const double reached = (bound - x[i]) / (to[i] - x[i]);
    if (reached < share || first < 0) {
      share = std::min(share, std::max(0.0, reached));
      first = i;
    }
  }
  for (int i = 0; i < x.size(); ++i)
    if (held[static_cast<std::size_t>(i)] == Held::kNo)
      x[i] = std::clamp(x[i] + share * (to[i] - x[i]), p.lower[i], p.upper[i]);
  if (first < 0) return false;
  const bool up = to[first] > p.upper[first];
  held[static_cast<std::size_t>(first)] = up ? Held::kUpper : Held::kLower;
  x[first] = up ? p.upper[first] : p.lower[first];
  return true;
}

/// Releases the active bound whose multiplier has the wrong sign by the most. \returns false if there is
/// none.
bool release_one(const BoxProblem& p, const JointVector& x, HeldVector& held) {
  int worst = -1;
  double by = 0.0;
  for (int i = 0; i < x.size(); ++i) {
    const Held at = held[static_cast<std::size_t>(i)];
    if (at == Held::kNo || p.lower[i] == p.upper[i]) continue;
    double slope = -p.g[i], size = std::abs(p.g[i]);
    for (int j = 0; j < x.size(); ++j) {
      slope += p.H(i, j) * x[j];
      size += std::abs(p.H(i, j) * x[j]);
    }
    const double inward = at == Held::kLower ? -slope : slope;  // > 0: descends away from the bound
    if (inward > kRounding * size && inward > by) {
      by = inward;
      worst = i;
    }
  }
  if (worst < 0) return false;
  held[static_cast<std::size_t>(worst)] = Held::kNo;
  return true;
}

}  // namespace

BoxSolution least_in_box(const BoxProblem& p) {
  const auto n = static_cast<int>(p.g.size());
  BoxSolution solution{JointVector::Zero(n), false};
  JointVector& x = solution.x;
  for (int i = 0; i < n; ++i) x[i] = std::clamp(0.0, p.lower[i], p.upper[i]);
  HeldVector held{};
  for (int i = 0; i < n; ++i)
    if (p.lower[i] == p.upper[i]) held[static_cast<std::size_t>(i)] = Held::kLower;
  for (int change = 0; change < kMaxChanges; ++change) {
    const JointVector to = least_of_free(p, x, held);
    if (!to.allFinite()) return solution;
    if (step_to_bound(p, x, to, held)) continue;
    if (!release_one(p, x, held)) {
      solution.optimal = true;
      return solution;
    }
  }
  return solution;
}

}  // namespace palpate

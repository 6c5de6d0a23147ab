#include <palpate/collision/k_function.h>

#include <cmath>

namespace palpate {
namespace {

/// Numerator p0 + p1 t + p2 t^2 and denominator 1 + e1 t + e2 t^2 + e3 t^3 of K, term by term. For
/// t > 1 both are divided by their highest power, so that nothing overflows.
struct Terms {
  double t;  ///< t, or 1/t if `inverted`
  bool inverted;
  double p[3];
  double e[4];

  double numerator() const { return p[0] + p[1] + p[2]; }
  double denominator() const { return e[0] + e[1] + e[2] + e[3]; }
  /// 1 - K. Restores the factors t/(1+t) and, if inverted, 1/t^2 and 1/t^3.
  double f() const { return numerator() / denominator() * t / (1.0 + t); }
};

Terms terms_at(const KFunction& k, double log_t) {
  const bool inverted = log_t > 0.0;
  const double t = std::exp(inverted ? -log_t : log_t);
  if (inverted) return {t, true, {k.p0 * t * t, k.p1 * t, k.p2}, {t * t * t, k.e1 * t * t, k.e2 * t, k.e3}};
  return {t, false, {k.p0, k.p1 * t, k.p2 * t * t}, {1.0, k.e1 * t, k.e2 * t * t, k.e3 * t * t * t}};
}

struct LogSlope {
  double first;   ///< g = d ln(1-K) / d ln t
  double second;  ///< dg / d ln t
};

/// The powers of t in numerator and denominator, weighted by their terms, have means and variances, which
/// give the logarithmic derivatives:
///
///     g = 1 - lambda + mean_p - mean_e = sum_kj (p_k t^k / P) (e_j t^j / E) (1 - lambda + k - j)
///
/// The sum is taken over pairs, because on a plateau of K (a disc of zero thickness) the three terms of the
/// short form cancel to rounding noise, while the pairs that matter there keep their precision.
LogSlope slope_at(const Terms& x) {
  const double n = x.numerator();
  const double d = x.denominator();
  const double lambda = (x.inverted ? 1.0 : x.t) / (1.0 + x.t);
  const double rest = (x.inverted ? x.t : 1.0) / (1.0 + x.t);  // 1 - lambda, to full precision
  double first = 0.0;
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 4; ++j) {
      const double factor = j == k + 1 ? -lambda : rest + (k - j);
      first += (x.p[k] / n) * (x.e[j] / d) * factor;
    }
  }
  const double n_mean = (x.p[1] + 2.0 * x.p[2]) / n;
  const double n_square = (x.p[1] + 4.0 * x.p[2]) / n;
  const double d_mean = (x.e[1] + 2.0 * x.e[2] + 3.0 * x.e[3]) / d;
  const double d_square = (x.e[1] + 4.0 * x.e[2] + 9.0 * x.e[3]) / d;
  return {first, (n_square - n_mean * n_mean) - lambda * rest - (d_square - d_mean * d_mean)};
}

/// Returns true if the minimum of K is beyond log_t.
bool descends(const KFunction& k, double log_t) { return slope_at(terms_at(k, log_t)).first > 0.0; }

/// ln t of the minimum of K for a ball of the Gaussian's extent along d'.
double initial_log_t(const KFunction& k) {
  const double extent = (k.L.transpose() * k.d).norm() / k.d.norm();
  constexpr double kSmallest = 1e-6;  // for a flat Gaussian; Newton's method needs no better start
  return -std::log(std::max(extent, kSmallest));
}

double to_lambda(double log_t) {
  return log_t > 0.0 ? 1.0 / (1.0 + std::exp(-log_t)) : std::exp(log_t) / (1.0 + std::exp(log_t));
}

}  // namespace

WhitenedTool::WhitenedTool(const Ellipsoid& tool)
    : ellipsoid(tool),
      W((tool.axes * tool.axes.colwise().squaredNorm().cwiseInverse().asDiagonal()).transpose()) {}

KFunction::KFunction(const WhitenedTool& tool, const Ellipsoid& gaussian)
    : KFunction(tool.W * (tool.ellipsoid.center - gaussian.center), tool.W * gaussian.axes) {}

KFunction::KFunction(const Eigen::Vector3d& distance, const Eigen::Matrix3d& l) : d(distance), L(l) {
  const Eigen::Vector3d l1 = L.col(0), l2 = L.col(1), l3 = L.col(2);
  const Eigen::Vector3d c12 = l1.cross(l2), c23 = l2.cross(l3), c31 = l3.cross(l1);
  const auto square = [](double v) { return v * v; };
  p0 = d.squaredNorm();
  p1 = l1.cross(d).squaredNorm() + l2.cross(d).squaredNorm() + l3.cross(d).squaredNorm();
  p2 = square(c12.dot(d)) + square(c23.dot(d)) + square(c31.dot(d));
  e1 = L.squaredNorm();
  e2 = c12.squaredNorm() + c23.squaredNorm() + c31.squaredNorm();
  e3 = square(c12.dot(l3));
}

double KFunction::operator()(double lambda) const {
  if (lambda <= 0.0) return 1.0;
  const double log_t = lambda < 1.0 ? std::log(lambda) - std::log1p(-lambda) : kMaxLogT;
  return 1.0 - terms_at(*this, log_t).f();
}

KMinimum minimize(const KFunction& k) {
  if (k.p0 == 0.0) return {1.0, 0.5, 0.0};
  constexpr int kMaxSteps = 200;       // bisection alone needs 45 to close the bracket
  constexpr double kTolerance = 1e-9;  // in ln t; at the minimum the error of K is its square
  double low = -kMaxLogT;
  double high = kMaxLogT;
  double log_t = std::clamp(initial_log_t(k), low, high);
  double change = high - low;
  for (int step = 0; step < kMaxSteps && high - low > 4.0 * kTolerance; ++step) {
    const LogSlope g = slope_at(terms_at(k, log_t));
    (g.first > 0.0 ? low : high) = log_t;
    double next = log_t - g.first / g.second;
    // Newton steps must shrink, or rounding makes them creep along a plateau.
    const bool trusted = g.second < 0.0 && next > low && next < high && std::abs(next - log_t) < 0.5 * change;
    if (!trusted) next = 0.5 * (low + high);
    change = std::abs(next - log_t);
    log_t = next;
    if (change >= kTolerance) continue;
    // On a plateau, where slope and curvature vanish, a small step does not prove convergence: the slope must
    // change its sign across it.
    const double before = std::max(low, log_t - kTolerance);
    const double after = std::min(high, log_t + kTolerance);
    if (!descends(k, before)) {
      high = before;
    } else if (descends(k, after)) {
      low = after;
    } else {
      break;
    }
    log_t = 0.5 * (low + high);
    change = high - low;
  }
  return {1.0 - terms_at(k, log_t).f(), to_lambda(log_t), log_t};
}

Eigen::Vector3d solve_whitened(const KFunction& k, double log_t) {
  const Eigen::Vector3d l1 = k.L.col(0), l2 = k.L.col(1), l3 = k.L.col(2);
  const Eigen::Vector3d c12 = l1.cross(l2), c23 = l2.cross(l3), c31 = l3.cross(l1);
  // adj(I + t S) d = d + t (e1 I - S) d + t^2 adj(S) d with S = L L^T.
  const Eigen::Vector3d first = l1.cross(k.d.cross(l1)) + l2.cross(k.d.cross(l2)) + l3.cross(k.d.cross(l3));
  const Eigen::Vector3d second = c12 * c12.dot(k.d) + c23 * c23.dot(k.d) + c31 * c31.dot(k.d);
  const Terms x = terms_at(k, log_t);
  const double t = x.t;
  if (x.inverted) return t * (t * (t * k.d + first) + second) / x.denominator();
  return (k.d + t * (first + t * second)) / x.denominator();
}

}  // namespace palpate

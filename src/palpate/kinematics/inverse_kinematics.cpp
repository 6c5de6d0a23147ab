#include <palpate/kinematics/inverse_kinematics.h>

#include <algorithm>
#include <cmath>
#include <random>

#include <palpate/kinematics/box_least_squares.h>

namespace palpate {
namespace {

constexpr double kFirstDamping = 1e-3, kLeastDamping = 1e-12, kMostDamping = 1e6;
/// Least relative decrease of the error in kPatience steps; less means a local minimum off the target.
constexpr double kLeastGain = 1e-3;
constexpr int kPatience = 8;

class Search {
 public:
  Search(const SerialChain& chain, const Pose& target, const InverseOptions& options)
      : limits_(chain), options_(options), target_(target), kinematics_(chain) {
    problem_.H.resize(chain.size(), chain.size());
    problem_.g.resize(chain.size());
  }

  bool from(const JointVector& seed) {
    q_ = seed.cwiseMax(limits_.lower).cwiseMin(limits_.upper);
    Vector6d error = error_at(q_);
    double damping = kFirstDamping, marked = size(error);
    for (int step = 0, since = 0; step < options_.steps; ++step) {
      if (reached(error)) return true;
      const JointVector next = improved(error, damping);
      const Vector6d after = error_at(next);
      if (size(after) < size(error)) {
        q_ = next;
        error = after;
        damping = std::max(kLeastDamping, 0.1 * damping);
      } else {
        damping *= 10.0;
        if (damping > kMostDamping) return false;
      }
      if (++since < kPatience) continue;
      if (size(error) > (1.0 - kLeastGain) * marked) return false;
      since = 0;
      marked = size(error);
    }
    return reached(error);
  }

  const JointVector& posture() const { return q_; }
  const ChainLimits& limits() const { return limits_; }

 private:
  Vector6d error_at(const JointVector& q) {
    kinematics_.set(q);
    return difference(kinematics_.tip(), target_);
  }

  double size(const Vector6d& e) const {
    return std::hypot(e.head<3>().norm(), options_.length * e.tail<3>().norm());
  }

  bool reached(const Vector6d& e) const {
    return e.head<3>().norm() <= options_.position && e.tail<3>().norm() <= options_.angle;
  }

  /// Returns q after one damped step, (J^T J + damping) dq = J^T error, within the limits.
  JointVector improved(const Vector6d& error, double damping) {
    kinematics_.set(q_);
    const Jacobian J = kinematics_.jacobian();
    const double squared = options_.length * options_.length;
    const auto dot = [&](const auto& a, const auto& b) {
      return a.template head<3>().dot(b.template head<3>()) +
             squared * a.template tail<3>().dot(b.template tail<3>());
    };
    for (Eigen::Index i = 0; i < q_.size(); ++i) {
      for (Eigen::Index j = 0; j <= i; ++j) problem_.H(i, j) = problem_.H(j, i) = dot(J.col(i), J.col(j));
      problem_.H(i, i) += damping;
      problem_.g[i] = dot(J.col(i), error);
    }
    problem_.lower = limits_.lower - q_;
    problem_.upper = limits_.upper - q_;
    return (q_ + least_in_box(problem_).x).cwiseMax(limits_.lower).cwiseMin(limits_.upper);
  }

  ChainLimits limits_;
  InverseOptions options_;
  Pose target_;
  ChainKinematics kinematics_;
  BoxProblem problem_;
  JointVector q_;
};

}  // namespace

std::optional<JointVector> inverse_kinematics(const SerialChain& chain, const Pose& target,
                                              const JointVector& seed, const InverseOptions& options) {
  if (!target.position.allFinite() || !(std::abs(target.orientation.norm() - 1.0) < 1e-3))
    return std::nullopt;
  Search search(chain, target, options);
  if (search.from(seed)) return search.posture();
  std::mt19937_64 random(1);
  const ChainLimits& limits = search.limits();
  for (int start = 1; start < options.starts; ++start) {
    JointVector drawn = limits.rest;
    for (Eigen::Index i = 0; i < drawn.size(); ++i) {
      const double share = static_cast<double>(random() >> 11) * 0x1p-53;
      drawn[i] = limits.lower[i] + share * (limits.upper[i] - limits.lower[i]);
    }
    if (search.from(drawn)) return search.posture();
  }
  return std::nullopt;
}

}  // namespace palpate

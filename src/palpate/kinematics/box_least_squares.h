/// \file
/// Box-constrained least squares: a small quadratic programme.
#pragma once

#include <palpate/kinematics/serial_chain.h>

namespace palpate {

/// minimise x^T H x / 2 - g^T x where lower <= x <= upper.
struct BoxProblem {
  JointMatrix H;             ///< symmetric, positive definite. Shape: [n, n], n <= kMaxJoints.
  JointVector g;             ///< Shape: [n].
  JointVector lower, upper;  ///< lower <= upper. Shape: [n].
};

struct BoxSolution {
  JointVector x;        ///< always within the bounds, also where `optimal` is false. Shape: [n].
  bool optimal = true;  ///< false after kMaxChanges changes of the active set, or for non-finite input
};

/// Solves `problem` by a primal active-set method: it steps towards the unconstrained minimum over the free
/// variables up to the first bound, which becomes active; where no bound is met, the active bound with the
/// wrong sign of its multiplier is released (Nocedal and Wright 2006, Algorithm 16.3, for bounds). H is
/// positive definite, so every step descends and no active set recurs. No heap allocation; throws nothing.
BoxSolution least_in_box(const BoxProblem& problem);

}  // namespace palpate

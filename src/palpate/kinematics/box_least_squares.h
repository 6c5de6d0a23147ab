/// \file
/// A small quadratic programme: least squares between bounds.
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
  bool optimal = true;  ///< false after kMaxChanges changes of the active set, or for what is not finite
};

/// By a primal active-set method: the unconstrained least among the free variables, a step towards it as far
/// as the first bound, which then holds; where there is none left, the bound with the wrong sign of its
/// multiplier is let go (Nocedal and Wright 2006, Algorithm 16.3, for bounds). H is positive definite, so
/// every step goes down and no set comes twice. Takes nothing from the heap, throws nothing.
BoxSolution least_in_box(const BoxProblem& problem);

}  // namespace palpate

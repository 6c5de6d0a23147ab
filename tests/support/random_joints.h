/// \file
/// Random postures of a chain.
#pragma once

#include <random>

#include <palpate/kinematics/serial_chain.h>
#include <support/uniform.h>

namespace palpate::test {

/// Anywhere within the limits.
inline JointVector posture(const ChainLimits& limits, std::mt19937_64& random) {
  JointVector q = limits.rest;
  for (Eigen::Index i = 0; i < q.size(); ++i) q[i] = uniform(random, limits.lower[i], limits.upper[i]);
  return q;
}

}  // namespace palpate::test

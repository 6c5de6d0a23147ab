/// \file
/// Extended-precision K of paper eqs. 5-6, for verdicts that double cannot decide.
#pragma once

#include <cstddef>

#include <palpate/collision/index_layout.h>
#include <palpate/collision/tool_frame.h>

namespace palpate {

/// K_min of a Gaussian and the tool in 113-bit arithmetic, taking the numbers of the block and ToolFrame::W
/// and center as exact: accurate to 1e-33 times the pair's size ratio, and its sign is the verdict. If
/// negative, it may be any value of K below zero. \param log_t initial guess, see KMinimum::log_t; the
/// closer, the faster. Takes about 20 us; throws nothing, allocates nothing; any thread.
double exact_k_min(const GaussianBlock& block, std::size_t lane, const ToolFrame& tool, double log_t);

}  // namespace palpate

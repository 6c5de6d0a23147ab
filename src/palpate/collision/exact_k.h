/// \file
/// K of paper eqs. 5-6 to more digits than double has, for verdicts that double cannot tell.
#pragma once

#include <cstddef>

#include <palpate/collision/index_layout.h>
#include <palpate/collision/tool_frame.h>

namespace palpate {

/// K_min of a Gaussian and the tool, from the numbers of the block and from ToolFrame::W and center as they
/// are, in 113 bits: good to 1e-33 times the pair's size ratio, and its sign is the verdict. Where that is
/// negative it may be any K below zero. \param log_t near the minimum, see KMinimum::log_t; nearer is faster.
/// Takes 20 us or so; throws nothing, allocates nothing; any thread.
double exact_k_min(const GaussianBlock& block, std::size_t lane, const ToolFrame& tool, double log_t);

}  // namespace palpate

/// \file
/// Stochastic thinning of small Gaussians where the candidates exceed the capacity.
#pragma once

#include <palpate/collision/contact_kernel.h>
#include <palpate/collision/pair_buffer.h>

namespace palpate {

/// Removes the pairs or candidates that are not in the sample of a grain (for candidates, their own grain);
/// see find_magnified(). Single precision. \pre the grain is positive
void sample(PairBuffer& pairs, float grain);
void sample(CandidateSet& candidates);

/// Frees room by enlarging the grain. \pre more than three quarters of the capacity are used
void coarsen(CandidateSet& candidates);

}  // namespace palpate

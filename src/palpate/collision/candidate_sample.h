/// \file
/// Where more Gaussians are near than there is room for: a sample of the smaller ones stands for all.
#pragma once

#include <palpate/collision/contact_kernel.h>
#include <palpate/collision/pair_buffer.h>

namespace palpate {

/// Leaves out what is not in the sample of a grain, that of the candidates themselves; see find_magnified().
/// Of single precision. \pre the grain is positive
void sample(PairBuffer& pairs, float grain);
void sample(CandidateSet& candidates);

/// Makes room, with a larger grain. \pre more than three quarters of it are taken
void coarsen(CandidateSet& candidates);

}  // namespace palpate

/// \file
/// Where more Gaussians are near than there is room for: a sample of the smaller ones stands for all.
#pragma once

#include <palpate/collision/contact_kernel.h>

namespace palpate {

/// Leaves out what, from number `first` on, is not in the sample of `candidates.grain`; see find_magnified().
void sample(CandidateSet& candidates, std::size_t first);

/// Makes room, with a larger grain. \pre more than three quarters of it are taken
void coarsen(CandidateSet& candidates);

}  // namespace palpate

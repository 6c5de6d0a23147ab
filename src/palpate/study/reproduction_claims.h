/// \file
/// Claims of section V of the paper with the measured figures.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <palpate/study/reproduction.h>

namespace palpate {

/// One statement of the paper.
struct Claim {
  enum class Bound { kAtMost, kAtLeast };

  std::string words;   ///< the paper's, or their sense
  std::string figure;  ///< the paper's, as it states it; "-": it states none
  std::string what;    ///< is measured, with its unit
  Bound bound = Bound::kAtMost;
  double limit = 0.0;  ///< that makes it true: the paper's figure, or what is said in `what`
  /// With the paper's pipeline and force, and with the defaults of this project; NaN: not to be known.
  double paper = 0.0, own = 0.0;

  bool holds(double value) const { return bound == Bound::kAtMost ? value <= limit : value >= limit; }
  /// How many times as good as the limit; NaN where that says nothing.
  double ratio(double value) const;
};

/// \param gaussians,kept of the scene, before and after its filter \param paper,own runs with
/// ReproductionDevice::kAdmittance along `path`, without stalls
std::vector<Claim> claims(std::size_t gaussians, std::size_t kept, const RoomPath& path,
                          const ReproductionRun& paper, const ReproductionRun& own);

}  // namespace palpate

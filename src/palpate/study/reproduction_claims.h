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

  std::string words;   ///< quotation from the paper, or its sense
  std::string figure;  ///< value that the paper states; "-" if none
  std::string what;    ///< the measured quantity, with its unit
  Bound bound = Bound::kAtMost;
  double limit = 0.0;  ///< bound within which it is true: the paper's value, or the one in `what`
  /// Values for the paper's pipeline and force, and for this project's defaults; NaN if unknown.
  double paper = 0.0, own = 0.0;

  bool holds(double value) const { return bound == Bound::kAtMost ? value <= limit : value >= limit; }
  /// Factor by which `value` is better than the limit; NaN if undefined.
  double ratio(double value) const;
};

/// \param gaussians,kept of the scene, before and after its filter \param paper,own runs with
/// ReproductionDevice::kAdmittance along `path`, without stalls
std::vector<Claim> claims(std::size_t gaussians, std::size_t kept, const RoomPath& path,
                          const ReproductionRun& paper, const ReproductionRun& own);

}  // namespace palpate

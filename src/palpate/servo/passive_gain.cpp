#include <palpate/servo/passive_gain.h>

#include <algorithm>
#include <cmath>

namespace palpate {

double PassiveGain::at(double gain, double stored) {
  const double whole = std::sqrt(gain * stored);
  const double had = std::max(0.0, std::sqrt(gain_ * stored) - lag_);
  gain_ = gain;
  root_ = std::min(whole, had);
  if (!(whole > 0.0)) {  // or NaN
    lag_ = 0.0;
    return gain;
  }
  lag_ = whole - root_;
  return gain * root_ / whole;
}

}  // namespace palpate

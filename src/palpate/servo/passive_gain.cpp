#include <palpate/servo/passive_gain.h>

#include <algorithm>
#include <cmath>

namespace palpate {

double PassiveGain::at(double gain, double stored, double given) {
  const double whole = std::sqrt(gain * stored);
  const double before = std::sqrt(gain_ * stored);
  const double with = std::max(0.0, before - lag_);
  // The fraction of `given` in U is the fraction of the force that is rendered.
  const double unearned = before > 0.0 ? gain_ * given * with / before : 0.0;
  const double had = std::sqrt(std::max(0.0, with * with - unearned));
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

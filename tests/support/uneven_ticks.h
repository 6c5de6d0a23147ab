/// \file
/// The clock of a loop on a machine that others use, too.
#pragma once

#include <random>

namespace palpate::test {

/// Ticks of 0.3 to 2 ms, now and then one of 6; the same at every run.
class UnevenTicks {
 public:
  /// When the next tick is. Unit: [s].
  double next() {
    t_ += random_() % 200 == 0 ? 6e-3 : 0.3e-3 + 1.7e-3 * static_cast<double>(random_() % 1000) / 1000.0;
    return t_;
  }

 private:
  std::mt19937 random_{18};
  double t_ = 0.0;
};

}  // namespace palpate::test

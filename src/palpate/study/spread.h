/// \file
/// Quantiles of repeated measurements, and curves of them.
#pragma once

#include <cstddef>
#include <vector>

namespace palpate {

/// Quantiles of a sample; NaN if it is empty.
struct Spread {
  double p05, p50, p95, p99, p999, max;
};

Spread spread_of(std::vector<double> values);

/// One point of a curve, from repeated measurements.
struct CurvePoint {
  double at;
  Spread value;
};

/// In increasing order of `at`; positions without measurements are omitted.
using Curve = std::vector<CurvePoint>;

/// Collects a curve in bins of equal width; values outside are dropped.
class CurveBins {
 public:
  /// \pre low < high, count > 0.
  CurveBins(double low, double high, std::size_t count)
      : low_(low), width_((high - low) / static_cast<double>(count)), bins_(count) {}

  void add(double at, double value);

  /// Returns one point per bin, at its middle.
  Curve curve() const;

 private:
  double low_, width_;
  std::vector<std::vector<double>> bins_;
};

}  // namespace palpate

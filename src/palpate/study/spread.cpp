#include <palpate/study/spread.h>

#include <cmath>
#include <limits>

#include <palpate/base/quantile.h>

namespace palpate {

Spread spread_of(std::vector<double> values) {
  if (values.empty()) {
    constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
    return {kUnknown, kUnknown, kUnknown, kUnknown, kUnknown, kUnknown};
  }
  return {quantile(values, 0.05), quantile(values, 0.5),   quantile(values, 0.95),
          quantile(values, 0.99), quantile(values, 0.999), quantile(values, 1.0)};
}

void CurveBins::add(double at, double value) {
  const double bin = std::floor((at - low_) / width_);
  if (bin >= 0.0 && bin < static_cast<double>(bins_.size()))
    bins_[static_cast<std::size_t>(bin)].push_back(value);
}

Curve CurveBins::curve() const {
  Curve curve;
  for (std::size_t i = 0; i < bins_.size(); ++i) {
    if (!bins_[i].empty())
      curve.push_back({low_ + (static_cast<double>(i) + 0.5) * width_, spread_of(bins_[i])});
  }
  return curve;
}

}  // namespace palpate

/// \file
/// Histogram of times on a logarithmic axis, as text and SVG.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace palpate {

/// Counts in bins of equal width on a logarithmic axis, from the least value to the largest or beyond.
class LogHistogram {
 public:
  /// \pre values are positive and not empty; bins > 0.
  LogHistogram(const std::vector<double>& values, std::size_t bins);

  std::size_t bins() const { return counts_.size(); }
  std::size_t count(std::size_t bin) const { return counts_[bin]; }
  std::size_t total() const { return total_; }
  /// Count of the fullest bin.
  std::size_t most() const;
  /// Lower edge of bin `i`; edge(bins()) is the upper edge of the last.
  double edge(std::size_t i) const;

 private:
  double low_, high_;
  std::size_t total_;
  std::vector<std::size_t> counts_;
};

/// Returns one line per bin, with a bar. Values are in microseconds.
std::string histogram_text(const std::vector<double>& times);

/// A marked value on the axis.
struct Mark {
  std::string name;
  double value;  ///< Unit: [us].
};

/// Returns a self-contained SVG document. Values are in microseconds. \pre times is not empty.
std::string histogram_svg(const std::vector<double>& times, const std::vector<Mark>& marks,
                          const std::string& title, const std::string& subtitle);

}  // namespace palpate

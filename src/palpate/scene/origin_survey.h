/// \file
/// Which origin lets single precision hold positions that a file has in double precision.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace palpate {

/// What Progress calls the pass over the positions.
inline constexpr const char* kSurveyStage = "surveying";

/// Looks at every position of a file once and remembers a bounded number of them.
class OriginSurvey {
 public:
  /// Positions remembered at most, evenly spread over the rows of the file: 24 MB. The median of so many
  /// is off by less than a percent of the spread of the scene.
  static constexpr std::uint64_t kMaxSample = std::uint64_t{1} << 20;

  /// \param count of the positions
  explicit OriginSurvey(std::uint64_t count);

  /// Takes the position in row `row` of 0 ... count-1; every row exactly once, from any thread.
  void add(std::uint64_t row, const Eigen::Vector3d& position);

  /// Zero if single precision holds every position as it is. Else the median of each coordinate of the
  /// sample, which no stray Gaussian moves, in whole units, which are exact to add back. Captured units.
  Eigen::Vector3d origin() const;

 private:
  std::uint64_t every_;  ///< one row in so many is remembered
  std::vector<Eigen::Vector3d> sample_;
  std::atomic<bool> exact_{true};
};

}  // namespace palpate

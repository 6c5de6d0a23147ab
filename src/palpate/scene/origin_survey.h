/// \file
/// Choice of an origin relative to which single precision holds a file's double-precision positions.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace palpate {

/// Progress stage name of the pass over the positions.
inline constexpr const char* kSurveyStage = "surveying";

/// Examines every position of a file once and keeps a bounded sample of them.
class OriginSurvey {
 public:
  /// Maximum sample size, evenly spread over the rows of the file: 24 MB. The error of its median is less
  /// than a percent of the spread of the scene.
  static constexpr std::uint64_t kMaxSample = std::uint64_t{1} << 20;

  /// \param count number of positions
  explicit OriginSurvey(std::uint64_t count);

  /// Adds the position in row `row` of 0 ... count-1; every row exactly once, from any thread.
  void add(std::uint64_t row, const Eigen::Vector3d& position);

  /// Zero if single precision represents every position exactly. Else the median of each coordinate of the
  /// sample, which is robust to stray Gaussians, rounded to whole units, which are exact to add back.
  /// Captured units.
  Eigen::Vector3d origin() const;

 private:
  std::uint64_t every_;  ///< sampling stride in rows
  std::vector<Eigen::Vector3d> sample_;
  std::atomic<bool> exact_{true};
};

}  // namespace palpate

// Which origin is chosen for positions in double precision, in bounded memory.
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include <palpate/base/quantile.h>
#include <palpate/scene/origin_survey.h>

namespace palpate::test {
namespace {

constexpr std::uint64_t kMany = 3 * OriginSurvey::kMaxSample + 1;

TEST(OriginSurvey, IsTheMedianOfEachCoordinateInWholeUnits) {
  OriginSurvey survey(3);
  survey.add(2, {0.1, -7.6, 1e300});
  survey.add(0, {500000.3, -7.4, std::numeric_limits<double>::quiet_NaN()});
  survey.add(1, {3.0, 900.0, 41.7});
  EXPECT_EQ(survey.origin(), Eigen::Vector3d(3, -7, 42));  // z: only one of them can be real
}

TEST(OriginSurvey, LooksAtEveryRowForWhatSinglePrecisionCannotHold) {
  for (const std::uint64_t odd_row : {std::uint64_t{0}, std::uint64_t{1}, kMany / 2, kMany - 1}) {
    OriginSurvey survey(kMany);
    for (std::uint64_t row = 0; row < kMany; ++row)
      survey.add(row, row == odd_row ? Eigen::Vector3d(0.1, 0, 0) : Eigen::Vector3d(1000, 0, 0));
    EXPECT_EQ(survey.origin(), Eigen::Vector3d(1000, 0, 0)) << odd_row;
  }
  OriginSurvey exact(kMany);
  for (std::uint64_t row = 0; row < kMany; ++row) exact.add(row, {1000, 0, 0});
  EXPECT_EQ(exact.origin(), Eigen::Vector3d::Zero());
}

TEST(OriginSurvey, TheMedianOfASampleIsCloseToThatOfAll) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  OriginSurvey survey(kMany);
  std::vector<double> all(kMany);
  for (std::uint64_t row = 0; row < kMany; ++row) {
    all[row] = 5.4e6 + 1e4 * normal(random);
    survey.add(row, {all[row], 0, 0});
  }
  // The standard error of a median of n is 1.2533 sigma / sqrt(n): 12.2 of 10,000 here.
  EXPECT_NEAR(survey.origin()[0], quantile(all, 0.5), 5 * 12.2);
}

TEST(OriginSurvey, EveryRowCountsUpToTheSizeOfTheSample) {
  // The exact median, which leaving out any row in the lower half would move.
  constexpr std::uint64_t kCount = OriginSurvey::kMaxSample - 1;
  OriginSurvey survey(kCount);
  for (std::uint64_t row = 0; row < kCount; ++row)
    survey.add(row, {static_cast<double>(row) + 0.1, 0.1, 0.1});
  EXPECT_EQ(survey.origin()[0], std::round((kCount - 1) / 2 + 0.1));
}

}  // namespace
}  // namespace palpate::test

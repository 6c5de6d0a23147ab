#include <cmath>

#include <gtest/gtest.h>

#include <palpate/study/spread.h>

namespace palpate {
namespace {

TEST(Spread, TakesTheValueOfNearestRank) {
  std::vector<double> values;
  for (int k = 1000; k >= 0; --k) values.push_back(k);
  const Spread spread = spread_of(values);
  EXPECT_EQ(spread.p05, 50.0);
  EXPECT_EQ(spread.p50, 500.0);
  EXPECT_EQ(spread.p95, 950.0);
  EXPECT_EQ(spread.p99, 990.0);
  EXPECT_EQ(spread.p999, 999.0);
  EXPECT_EQ(spread.max, 1000.0);
}

TEST(Spread, OfNothingIsNotANumber) {
  EXPECT_TRUE(std::isnan(spread_of({}).p50));
  EXPECT_TRUE(std::isnan(spread_of({}).max));
}

TEST(CurveBins, GatherByPlaceAndLeaveOutWhatIsEmptyOrOutside) {
  CurveBins bins(-1.0, 3.0, 4);
  for (const double value : {5.0, 6.0, 7.0}) bins.add(0.5, value);
  bins.add(-1.0, 1.0);  // the first bin begins there
  bins.add(-1.1, 9.0);
  bins.add(3.0, 9.0);  // and the last ends before here
  const Curve curve = bins.curve();
  ASSERT_EQ(curve.size(), 2U);
  EXPECT_EQ(curve[0].at, -0.5);
  EXPECT_EQ(curve[0].value.max, 1.0);
  EXPECT_EQ(curve[1].at, 0.5);
  EXPECT_EQ(curve[1].value.p50, 6.0);
  EXPECT_EQ(curve[1].value.max, 7.0);
}

}  // namespace
}  // namespace palpate

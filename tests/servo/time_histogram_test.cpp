#include <palpate/servo/time_histogram.h>

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr double kClass = 0.05;  // relative width of a class, at most

TEST(TimeHistogram, OfNothingIsZero) {
  const TimeHistogram times;
  EXPECT_EQ(times.count(), 0U);
  EXPECT_EQ(times.quantile(0.5), 0.0);
  EXPECT_EQ(times.max(), 0.0);
}

TEST(TimeHistogram, QuantilesAreThoseOfTheTimesToTheWidthOfAClass) {
  TimeHistogram times;
  for (int k = 1; k <= 1000; ++k) times.add(1e-6 * k);
  EXPECT_EQ(times.count(), 1000U);
  EXPECT_NEAR(times.quantile(0.5), 500e-6, kClass * 500e-6);
  EXPECT_NEAR(times.quantile(0.99), 990e-6, kClass * 990e-6);
  EXPECT_EQ(times.quantile(1.0), 1e-3);
  EXPECT_LE(times.quantile(0.999), times.max());
}

TEST(TimeHistogram, OneInAThousandIsSeenInTheTail) {
  TimeHistogram times;
  for (int k = 0; k < 9980; ++k) times.add(10e-6);
  for (int k = 0; k < 20; ++k) times.add(3e-3);
  EXPECT_NEAR(times.quantile(0.99), 10e-6, kClass * 10e-6);
  EXPECT_NEAR(times.quantile(0.999), 3e-3, kClass * 3e-3);
}

TEST(TimeHistogram, TimesOutsideTheClassesCount) {
  TimeHistogram times;
  for (const double t : {-1.0, 0.0, 1e-12, 1e6}) times.add(t);
  EXPECT_EQ(times.count(), 4U);
  EXPECT_LT(times.quantile(0.5), 2e-8);
  EXPECT_EQ(times.max(), 1e6);
}

TEST(TimeWindow, HasWhatCameSinceTheLastLook) {
  TimeHistogram times;
  TimeWindow window(times);
  window.next();
  EXPECT_EQ(window.count(), 0U);
  EXPECT_EQ(window.mean(), 0.0);
  EXPECT_EQ(window.quantile(0.99), 0.0);
  for (int k = 0; k < 1000; ++k) times.add(5e-3);
  window.next();
  EXPECT_EQ(window.count(), 1000U);
  EXPECT_NEAR(window.mean(), 5e-3, kClass * 5e-3);
  for (int k = 1; k <= 1000; ++k) times.add(1e-6 * k);
  window.next();
  EXPECT_EQ(window.count(), 1000U) << "not what came before";
  EXPECT_NEAR(window.mean(), 500e-6, kClass * 500e-6);
  EXPECT_NEAR(window.quantile(0.5), 500e-6, kClass * 500e-6);
  EXPECT_NEAR(window.quantile(0.99), 990e-6, kClass * 990e-6);
  window.next();
  EXPECT_EQ(window.count(), 0U);
}

}  // namespace
}  // namespace palpate

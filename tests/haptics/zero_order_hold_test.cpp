#include <palpate/haptics/zero_order_hold.h>

#include <cmath>

#include <gtest/gtest.h>

namespace palpate {
namespace {

/// Pushes by as many newtons as the tool is at x, and remembers what it was told.
struct Echo final : ForceModel {
  double dt = -1.0;
  int resets = 0;

  bool wants_contacts() const override { return false; }
  void reset() override { ++resets; }
  ForceOutput evaluate(const ForceInput& input) override {
    dt = input.dt;
    ForceOutput out;
    out.wrench.force.x() = input.tool.position.x();
    return out;
  }
};

ForceInput at(double x, double dt) {
  ForceInput input;
  input.tool.position.x() = x;
  input.dt = dt;
  return input;
}

TEST(ZeroOrderHold, IsZeroUntilThereIsAnAnswer) {
  Echo echo;
  ZeroOrderHold held(echo, nullptr);
  held.finish();  // nothing was asked
  EXPECT_EQ(held.evaluate(at(3, 0)).wrench.force.x(), 0.0);
  EXPECT_EQ(held.evaluate(at(4, 1e-3)).wrench.force.x(), 0.0);
  EXPECT_FALSE(held.evaluate(at(4, 1e-3)).is_known);
  held.take();
  held.finish();
  EXPECT_TRUE(held.evaluate(at(4, 1e-3)).is_known);
}

TEST(ZeroOrderHold, HoldsWhatWasFeltWhenItWasAsked) {
  Echo echo;
  ZeroOrderHold held(echo, nullptr);
  held.evaluate(at(1, 0));
  held.take();
  held.evaluate(at(2, 1e-3));
  held.finish();
  EXPECT_EQ(held.evaluate(at(3, 1e-3)).wrench.force.x(), 1.0);
  EXPECT_EQ(held.evaluate(at(4, 1e-3)).wrench.force.x(), 1.0);
  held.take();
  held.finish();
  EXPECT_EQ(held.evaluate(at(5, 1e-3)).wrench.force.x(), 4.0);
  EXPECT_DOUBLE_EQ(echo.dt, 3e-3);  // between the two that it saw
  held.take();
  held.finish();
  EXPECT_DOUBLE_EQ(echo.dt, 1e-3);  // since the last of them, not since the first
  EXPECT_TRUE(std::isnan(held.evaluate(at(5, 1e-3)).stored_energy));
}

TEST(ZeroOrderHold, AnAnswerFromBeforeAResetIsNotTold) {
  Echo echo;
  ZeroOrderHold held(echo, nullptr);
  held.evaluate(at(1, 0));
  held.take();
  held.reset();
  held.finish();
  EXPECT_EQ(held.evaluate(at(2, 0)).wrench.force.x(), 0.0);
  held.take();
  held.finish();
  EXPECT_EQ(held.evaluate(at(3, 1e-3)).wrench.force.x(), 2.0);
  EXPECT_EQ(echo.resets, 2);
  EXPECT_EQ(echo.dt, 0.0);
}

}  // namespace
}  // namespace palpate

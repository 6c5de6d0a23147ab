// The tool as the lanes want it: nothing of it may be lost or cut off on the way to single precision.

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <palpate/collision/tool_frame.h>
#include <support/random_pairs.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

struct Drawn {
  Ellipsoid tool;
  Similarity world;
  Vector3d origin;
};

/// Any tool, near and far from the world's, the captured frame's and the index's origin.
Drawn draw(test::Random& random) {
  const auto within = [&](double farthest) {
    const double distance = random.log_uniform(1e-3, farthest);
    return Vector3d(distance * random.direction());
  };
  Drawn drawn;
  const Pose pose{within(1e7), random.rotation()};
  const double size = random.log_uniform(1e-3, 10.0);
  drawn.tool = Ellipsoid::from_semi_axes(pose, size * random.semi_axes(0.01, 1.0));
  drawn.origin = random.integer(0, 1) == 0 ? Vector3d(0, 0, 0) : within(1e7);
  if (random.integer(0, 1) == 0) {
    const double scale = random.log_uniform(1e-3, 1e3);
    drawn.world = {scale, random.rotation(), within(1e7)};
  }
  // Near the index's origin, however far both are from the world's: there much of the centre cancels.
  if (random.integer(0, 2) == 0) drawn.tool.center = drawn.world * (drawn.origin + within(10.0));
  return drawn;
}

/// Rounding of the centre on its way to the captured frame. Unit: [captured units].
double rounding(const Drawn& d) {
  const double size = d.tool.center.norm() + d.world.translation.norm() + d.world.scale * d.origin.norm();
  return 16.0 * std::numeric_limits<double>::epsilon() * size / d.world.scale;
}

TEST(ToolFrame, TheCentreIsTheSumOfItsParts) {
  test::Random random(601);
  for (int i = 0; i < 10000; ++i) {
    const Drawn d = draw(random);
    const ToolFrame frame(d.tool, CapturedFrame(d.world, d.origin));
    const Vector3d expected = d.world.inverse() * d.tool.center - d.origin;
    ASSERT_LE((frame.center - expected).norm(), rounding(d));
    const Vector3d sum = frame.center_high.cast<double>() + frame.center_low.cast<double>();
    ASSERT_LE((sum - frame.center).cwiseAbs().maxCoeff(), 0x1p-47 * frame.center.norm())
        << "of " << frame.center.transpose() << " the low part is " << frame.center_low.transpose();
  }
}

TEST(ToolFrame, TheBoxContainsTheTool) {
  test::Random random(602);
  for (int i = 0; i < 10000; ++i) {
    const Drawn d = draw(random);
    const ToolFrame frame(d.tool, CapturedFrame(d.world, d.origin));
    const Eigen::Matrix3d axes =
        d.world.rotation.conjugate().toRotationMatrix() * d.tool.axes / d.world.scale;
    const Vector3d half = axes.rowwise().norm();
    ASSERT_TRUE((frame.low.cast<double>().array() <= (frame.center - half).array()).all());
    ASSERT_TRUE((frame.high.cast<double>().array() >= (frame.center + half).array()).all());
    const double most = 2.0 * half.norm() + 1e-6 * frame.center.norm() + 16.0 * rounding(d);
    ASSERT_LE((frame.high - frame.low).cast<double>().maxCoeff(), most) << "needlessly large";
  }
}

TEST(ToolFrame, WhitensTheCapturedFrame) {
  test::Random random(603);
  for (int i = 0; i < 1000; ++i) {
    const Drawn d = draw(random);
    const ToolFrame frame(d.tool, CapturedFrame(d.world, d.origin));
    // A captured vector on the surface of the tool becomes a unit vector.
    const Vector3d u = random.direction();
    const Vector3d captured = d.world.rotation.conjugate() * (d.tool.axes * u) / d.world.scale;
    const double kappa = d.tool.radius() / d.tool.axes.colwise().norm().minCoeff();
    ASSERT_NEAR((frame.W * captured).norm(), 1.0, 1e-14 * kappa);
    ASSERT_LE((frame.W_float.cast<double>() - frame.W).cwiseAbs().maxCoeff(), 0x1p-23 * frame.W.norm());
    // A captured unit reaches one over the shortest semi-axis, in tool radii, and no more.
    const double reach = d.world.scale / d.tool.axes.colwise().norm().minCoeff();
    ASSERT_GE(frame.reach_per_length, reach);
    ASSERT_LE(frame.reach_per_length, reach * (1.0 + 1e-5));
  }
}

}  // namespace
}  // namespace palpate

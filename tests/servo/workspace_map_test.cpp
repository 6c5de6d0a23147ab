#include <palpate/servo/workspace_map.h>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

WorkspaceMap some_map() {
  return {4.0,
          Quaterniond(AngleAxisd(1.1, Vector3d(1, -2, 0.5).normalized())),
          {0.3, -0.2, 1.0},
          Quaterniond(AngleAxisd(0.4, Vector3d(2, 1, -1).normalized()))};
}

DevicePose some_pose() {
  return {{0.05, 0.02, -0.03}, Quaterniond(AngleAxisd(0.7, Vector3d(0, 1, 2).normalized()))};
}

Quaterniond turned(const Vector3d& by) { return Quaterniond(AngleAxisd(by.norm(), by.normalized())); }

TEST(WorkspaceMap, ByDefaultTheDeviceIsInTheWorld) {
  const WorkspaceMap map;
  EXPECT_EQ(map.to_world(some_pose()).position, some_pose().position);
  EXPECT_EQ(map.to_device(Wrench{{1, 2, 3}, {4, 5, 6}}).torque, Vector3d(4, 5, 6));
}

TEST(WorkspaceMap, ThereAndBackIsTheSamePose) {
  const DevicePose back = some_map().to_device(some_map().to_world(some_pose()));
  EXPECT_TRUE(back.position.isApprox(some_pose().position, 1e-12));
  EXPECT_TRUE(back.orientation.isApprox(some_pose().orientation, 1e-12));
}

TEST(WorkspaceMap, AttachesAToolToAHandle) {
  WorkspaceMap map = some_map();
  const Pose tool{{1, 2, 3}, Quaterniond(AngleAxisd(2.0, Vector3d(1, 1, 0).normalized()))};
  map.attach(tool, some_pose());
  EXPECT_TRUE(map.to_world(some_pose()).position.isApprox(tool.position, 1e-12));
  EXPECT_LT(map.to_world(some_pose()).orientation.angularDistance(tool.orientation), 1e-7);
  EXPECT_EQ(map.rotation.coeffs(), some_map().rotation.coeffs()) << "which forces go by";
}

TEST(WorkspaceMap, AMetreOfTheHandIsScaleMetresOfTheWorld) {
  WorkspaceMap map;
  map.scale = 3.0;
  map.rotation = turned({0, 0, 1.5707963267948966});
  EXPECT_TRUE(map.to_world(DevicePose{{1, 0, 0}, Quaterniond::Identity()})
                  .position.isApprox(Vector3d(0, 3, 0), 1e-12));
  EXPECT_TRUE(map.to_world(Twist{{1, 0, 0}, {1, 0, 0}}).angular.isApprox(Vector3d(0, 1, 0), 1e-12));
}

// A spring of the world is as stiff in the hand, and its force is the gradient of the energy that it is said
// to have there.
TEST(WorkspaceMap, ASpringIsAsStiffInTheHandAndConservative) {
  constexpr double kStiffness = 500.0, kTurning = 0.8, kStep = 1e-6;
  const WorkspaceMap map = some_map();
  const Pose rest = map.to_world(DevicePose{});
  const auto turn_of = [&](const Pose& world) {
    const AngleAxisd turn(world.orientation * rest.orientation.conjugate());
    return Vector3d(turn.angle() * turn.axis());
  };
  const auto energy = [&](const DevicePose& device) {
    const Pose world = map.to_world(device);
    return map.to_device(0.5 * kStiffness * (world.position - rest.position).squaredNorm() +
                         0.5 * kTurning * turn_of(world).squaredNorm());
  };
  const DevicePose at{{0.01, -0.02, 0.005}, turned({0.02, -0.03, 0.01})};
  const Pose world = map.to_world(at);
  const Wrench felt =
      map.to_device(Wrench{-kStiffness * (world.position - rest.position), -kTurning * turn_of(world)});
  EXPECT_TRUE(felt.force.isApprox(-kStiffness * at.position, 1e-9));
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d step = kStep * Vector3d::Unit(axis);
    const double by_way =
        energy({at.position + step, at.orientation}) - energy({at.position - step, at.orientation});
    const double by_turn = energy({at.position, turned(step) * at.orientation}) -
                           energy({at.position, turned(-step) * at.orientation});
    EXPECT_NEAR(felt.force[axis], -by_way / (2 * kStep), 1e-6);
    EXPECT_NEAR(felt.torque[axis], -by_turn / (2 * kStep), 1e-6);
  }
}

}  // namespace
}  // namespace palpate

// A reading of a device is not a pose of the world, and the compiler says so.

#include <type_traits>

#include <gtest/gtest.h>

#include <palpate/haptics/force_model.h>
#include <palpate/haptics/tool.h>
#include <palpate/servo/motion_device.h>
#include <palpate/servo/safety_governor.h>
#include <palpate/servo/workspace_map.h>

namespace palpate {
namespace {

using Reading = decltype(DeviceReading::pose);
// So is what a device with its own position control reads and is told.
static_assert(std::is_same_v<decltype(MotionReading::pose), Reading>);
static_assert(std::is_same_v<decltype(MotionSetpoint::pose), Reading>);

static_assert(!std::is_convertible_v<Reading, Pose> && !std::is_constructible_v<Pose, Reading>);
static_assert(!std::is_assignable_v<decltype((ForceInput::tool)), Reading>);
static_assert(!std::is_invocable_v<decltype(&ToolPart::at), const ToolPart&, const Reading&>);
// Nor is a pose of the world taken for a reading, without a word that says so.
static_assert(!std::is_convertible_v<Pose, Reading>);
static_assert(!std::is_assignable_v<Reading&, Pose>);

template <class T>
concept GoesToTheWorld = requires(const WorkspaceMap& map, const T& pose) {
  map.to_world(pose);
};
template <class T>
concept GoesToTheDevice = requires(const WorkspaceMap& map, const T& pose) {
  map.to_device(pose);
};
static_assert(GoesToTheWorld<Reading> && !GoesToTheWorld<Pose>);
static_assert(GoesToTheDevice<Pose> && !GoesToTheDevice<Reading>);

TEST(DevicePose, IsInTheWorldWhereTheMapHasIt) {
  const DevicePose X_DH({1, 2, 3}, Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5));
  EXPECT_EQ(DevicePose(X_DH.in_device_frame()), X_DH);
  WorkspaceMap map;
  map.scale = 2.0;
  map.offset = {0, 0, 1};
  const Pose X_WT = map.to_world(X_DH);
  EXPECT_EQ(X_WT.position, Eigen::Vector3d(2, 4, 7));
  EXPECT_EQ(X_WT.orientation, X_DH.orientation);
}

}  // namespace
}  // namespace palpate

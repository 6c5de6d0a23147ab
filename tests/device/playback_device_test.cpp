#include <palpate/device/playback_device.h>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

Trajectory line() {
  Trajectory t(2);
  t[0].t = 100.0;
  t[1].t = 102.0;
  t[1].pose.position = {0.2, 0, 0};
  return t;
}

TEST(PlaybackDevice, TellsTheTrajectoryFromTheFirstReadingOn) {
  PlaybackDevice device({}, line());
  DeviceReading reading;
  EXPECT_TRUE(device.read(7.0, reading));
  EXPECT_EQ(reading.pose.position, Vector3d(0, 0, 0));
  EXPECT_EQ(reading.velocity.linear, Vector3d(0, 0, 0));
  EXPECT_TRUE(device.read(7.5, reading));
  EXPECT_EQ(reading.t, 7.5);
  EXPECT_NEAR(reading.pose.position.x(), 0.05, 1e-12);
  EXPECT_NEAR(reading.velocity.linear.x(), 0.1, 1e-12);
}

TEST(PlaybackDevice, StaysAtTheEnd) {
  PlaybackDevice device({}, line());
  DeviceReading reading;
  device.read(0.0, reading);
  device.read(50.0, reading);
  EXPECT_EQ(reading.pose.position, Vector3d(0.2, 0, 0));
  device.read(50.001, reading);
  EXPECT_EQ(reading.velocity.linear, Vector3d(0, 0, 0));
  EXPECT_EQ(device.length(), 2.0);
}

TEST(PlaybackDevice, HasNothingNewAtTheSameTime) {
  PlaybackDevice device({}, line());
  DeviceReading reading;
  EXPECT_TRUE(device.read(1.0, reading));
  EXPECT_FALSE(device.read(1.0, reading));
}

}  // namespace
}  // namespace palpate

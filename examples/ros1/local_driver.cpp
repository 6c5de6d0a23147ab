/// \file
/// A driver on ROS 1, in place of that of a device: sends poses as CRTK does, 1000 times a second, and makes
/// the force itself from the local model where one comes, behind the governor of the reference client
/// (docs/ros.md). The handle is a simulated one in a simulated hand, which presses on what is below it.
///
///     g++ -std=c++17 -O2 -pthread -I../client local_driver.cpp -o local_driver $(pkg-config --libs roscpp)
///     ./local_driver PREFIX X Y Z [wrench|local]
///
/// X Y Z is where the hand wants to be, in metres. Prints, each second, where the handle is, the force that
/// it is shown, the force of the newest wrench, and what came how soon.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <ros/ros.h>
#include <std_msgs/Float64MultiArray.h>
#include <std_msgs/Header.h>

#include "palpate_client.h"

namespace {

using palpate_client::Limits;
using palpate_client::Vector;
using palpate_client::Wrench;
using palpate_client::WrenchGovernor;

constexpr double kTick = 1e-3;
constexpr double kDamping = 2.0;  // of device and hand. Unit: [N s/m].
constexpr double kAbove = 0.03;   // over where it presses, from where the hand comes. Unit: [m].

/// Of a stamp that comes back as a double.
std::uint64_t microseconds(const ros::Time& stamp) { return (stamp.toNSec() + 500) / 1000; }

/// A mass on a spring of the hand's, along z.
struct Handle {
  double z, target, velocity = 0.0;

  void move(double wanted, double force) {
    constexpr double kMass = 0.2, kStiffness = 300.0, kSpeed = 0.03;  // kg, N/m, m/s
    target += std::clamp(wanted - target, -kSpeed * kTick, kSpeed * kTick);
    constexpr int kSteps = 20;
    for (int k = 0; k < kSteps; ++k) {
      velocity += kTick / kSteps * (kStiffness * (target - z) - kDamping * velocity + force) / kMass;
      z += kTick / kSteps * velocity;
    }
  }
};

class Driver {
 public:
  Driver(const std::string& prefix, bool local)
      : governor_({8.0, 0.0, local ? kDamping : 0.0}),
        poses_(node_.advertise<geometry_msgs::PoseStamped>(prefix + "/measured_cp", 4)),
        echoed_(node_.advertise<std_msgs::Header>(prefix + "/palpate/echoed", 4)) {
    const auto hints = ros::TransportHints().tcpNoDelay();
    subscribers_.push_back(node_.subscribe(prefix + "/spatial/servo_cf", 1, &Driver::take, this, hints));
    subscribers_.push_back(node_.subscribe(prefix + "/palpate/echo", 1, &Driver::answer, this, hints));
    if (local)
      subscribers_.push_back(
          node_.subscribe(prefix + "/palpate/local_model", 1, &Driver::take_model, this, hints));
  }

  /// \returns the force at `position`, which is told.
  double tick(const Vector& position) {
    ros::Time now = ros::Time::now();
    now.nsec -= now.nsec % 1000;  // whole microseconds, which come back as they were
    const double force = governor_.show(position, now.toSec()).force[2];
    geometry_msgs::PoseStamped pose;
    pose.header.stamp = now;
    pose.header.frame_id = "base";
    pose.pose.position.x = position[0];
    pose.pose.position.y = position[1];
    pose.pose.position.z = position[2];
    pose.pose.orientation.w = 1.0;
    {
      const std::scoped_lock lock(mutex_);
      sent_[microseconds(now)] = ros::SteadyTime::now();
    }
    poses_.publish(pose);
    return force;
  }

  /// Of the last second.
  void print(double z, double force) {
    const std::scoped_lock lock(mutex_);
    std::sort(trips_.begin(), trips_.end());
    const auto trip = [&](double p) {
      return trips_.empty() ? 0.0
                            : trips_[static_cast<std::size_t>(p * static_cast<double>(trips_.size() - 1))];
    };
    std::printf(
        "z %.5f m, shown %.3f N, wrench %.3f N; poses %zu, answered %zu, wrenches %d, lost %d, models %d; "
        "p50 %.3f "
        "ms, p99 "
        "%.3f ms\n",
        z, force, wrench_, sent_.size() + trips_.size(), trips_.size(), wrenches_, lost_, models_,
        1e3 * trip(0.5), 1e3 * trip(0.99));
    std::fflush(stdout);
    trips_.clear();
    sent_.clear();
    wrenches_ = lost_ = models_ = 0;
  }

 private:
  void take(const geometry_msgs::WrenchStamped& message) {
    const auto& [force, torque] = std::tie(message.wrench.force, message.wrench.torque);
    governor_.take({{force.x, force.y, force.z}, {torque.x, torque.y, torque.z}},
                   message.header.stamp.toSec(), ros::Time::now().toSec());
    const std::scoped_lock lock(mutex_);
    wrench_ = force.z;
    ++wrenches_;
    if (number_ != 0) lost_ += static_cast<int>(message.header.seq - number_) - 1;
    number_ = message.header.seq;
    const auto at = sent_.find(microseconds(message.header.stamp));
    if (at == sent_.end()) return;
    trips_.push_back((ros::SteadyTime::now() - at->second).toSec());
    sent_.erase(at);
  }

  void take_model(const std_msgs::Float64MultiArray& message) {
    namespace messages = palpate_client::messages;
    governor_.take_model(messages::local_model(message.data), messages::measured_at(message.data),
                         ros::Time::now().toSec());
    const std::scoped_lock lock(mutex_);
    ++models_;
  }

  /// Palpate finds out by this how long messages take, and how far the clocks are apart.
  void answer(const std_msgs::Header& echo) {
    std_msgs::Header back;
    back.seq = echo.seq;
    back.stamp = ros::Time::now();
    echoed_.publish(back);
  }

  ros::NodeHandle node_;
  WrenchGovernor governor_;
  ros::Publisher poses_, echoed_;
  std::vector<ros::Subscriber> subscribers_;
  std::mutex mutex_;                               // of what follows
  std::map<std::uint64_t, ros::SteadyTime> sent_;  // by microseconds() of the stamp
  std::vector<double> trips_;
  double wrench_ = 0.0;
  int wrenches_ = 0, lost_ = 0, models_ = 0;
  std::uint32_t number_ = 0;  // of the newest wrench
};

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "local_driver", ros::init_options::AnonymousName);
  if (argc != 5 && argc != 6) {
    std::fprintf(stderr, "usage: local_driver PREFIX X Y Z [wrench|local]\n");
    return 2;
  }
  const bool local = argc == 5 || std::strcmp(argv[5], "local") == 0;
  const double x = std::atof(argv[2]), y = std::atof(argv[3]), z = std::atof(argv[4]);
  Driver driver(argv[1], local);
  ros::AsyncSpinner spinner(1);
  spinner.start();
  Handle handle{z + kAbove, z + kAbove};
  double force = 0.0;
  const auto begin = std::chrono::steady_clock::now();
  for (int k = 0; ros::ok(); ++k) {
    // A second and a half above, in which the gates open.
    handle.move(k < 1500 ? z + kAbove : z, force);
    force = driver.tick({x, y, handle.z});
    if (k % 1000 == 999) driver.print(handle.z, force);
    std::this_thread::sleep_until(begin + std::chrono::milliseconds(k + 1));
  }
  return 0;
}

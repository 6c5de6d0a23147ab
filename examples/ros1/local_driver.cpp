/// \file
/// A driver on ROS 1, in place of that of a device: sends poses as CRTK does, 1000 times a second, and makes
/// the force itself from the local model where one comes, behind the governor of the reference client
/// (docs/ros.md). The handle is a simulated one in a simulated hand, which presses on what is below it.
///
///     g++ -std=c++17 -O2 -pthread -I../client local_driver.cpp -o local_driver $(pkg-config --libs roscpp)
///     ./local_driver PREFIX X Y Z [wrench|local]
///
/// X Y Z is where the hand wants to be, in metres. Prints, each second, where the handle is, the force that
/// it is shown, the force of the newest wrench, and what came how soon. On SIGINT, SIGTERM, SIGHUP and
/// `rosnode kill` the force falls before it ends.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <exception>
#include <limits>
#include <mutex>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

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
constexpr double kRemembered = 1.0;  // how long a pose is. Unit: [s].
constexpr double kNever = -std::numeric_limits<double>::infinity();
constexpr double kDamping = 2.0;  // of device and hand. Unit: [N s/m].
constexpr double kAbove = 0.03;   // over where it presses, from where the hand comes. Unit: [m].

/// The governor's clock, which never falls; that of ROS is set, and is for stamps only. Unit: [s].
double steady() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Of a stamp that comes back as a double. 0: it is none.
std::uint64_t microseconds(double stamp) {
  return stamp > 0.0 && stamp < 4294967296.0 ? static_cast<std::uint64_t>(std::llround(1e6 * stamp)) : 0;
}

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

/// Motors keep the last force that they were told. Whatever ends the loop, an exception of the driver too,
/// the last is zero.
class Motors {
 public:
  ~Motors() { show(0.0); }
  void show(double force) noexcept { force_ = force; }
  double force() const noexcept { return force_; }

 private:
  double force_ = 0.0;
};

volatile std::sig_atomic_t ends = 0;

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

  /// \returns the force at `position`.
  double force(const Vector& position) noexcept { return governor_.show(position, steady()).force[2]; }

  /// Tells where the handle is.
  void send(const Vector& position) {
    const double at = steady();
    ros::Time now = ros::Time::now();
    now.nsec -= now.nsec % 1000;  // whole microseconds, which come back as they were
    geometry_msgs::PoseStamped pose;
    pose.header.stamp = now;
    pose.header.frame_id = "base";
    pose.pose.position.x = position[0];
    pose.pose.position.y = position[1];
    pose.pose.position.z = position[2];
    pose.pose.orientation.w = 1.0;
    {
      const std::scoped_lock lock(mutex_);
      while (!sent_.empty() && at - sent_.front().at > kRemembered) sent_.pop_front();
      sent_.push_back({microseconds(now.toSec()), at});
      ++count_;
    }
    poses_.publish(pose);
  }

  /// What has come since the last call.
  std::string summary() {
    const std::scoped_lock lock(mutex_);
    std::sort(trips_.begin(), trips_.end());
    const auto trip = [&](double p) {
      return trips_.empty() ? 0.0
                            : trips_[static_cast<std::size_t>(p * static_cast<double>(trips_.size() - 1))];
    };
    std::array<char, 256> text{};
    std::snprintf(text.data(), text.size(),
                  "wrench %.3f N; poses %d, answered %zu, wrenches %d, lost %d, models %d; p50 %.3f ms, p99 "
                  "%.3f ms",
                  wrench_, count_, trips_.size(), wrenches_, lost_, models_, 1e3 * trip(0.5),
                  1e3 * trip(0.99));
    trips_.clear();
    count_ = wrenches_ = lost_ = models_ = 0;
    return text.data();
  }

 private:
  /// A pose that was sent.
  struct Sent {
    std::uint64_t stamp;  ///< microseconds()
    double at;            ///< on the governor's clock. Unit: [s].
    bool answered = false;
  };

  /// \returns the newest pose with this stamp; nullptr: there is none. \pre mutex_ is locked
  Sent* find(double stamp) {
    const auto found = std::find_if(sent_.rbegin(), sent_.rend(),
                                    [n = microseconds(stamp)](const Sent& sent) { return sent.stamp == n; });
    return found == sent_.rend() ? nullptr : &*found;
  }

  void take(const geometry_msgs::WrenchStamped& message) {
    const double now = steady();
    const auto& [force, torque] = std::tie(message.wrench.force, message.wrench.torque);
    double measured_at = kNever;
    {
      const std::scoped_lock lock(mutex_);
      wrench_ = force.z;
      ++wrenches_;
      if (number_ != 0) lost_ += static_cast<int>(message.header.seq - number_) - 1;
      number_ = message.header.seq;
      if (Sent* pose = find(message.header.stamp.toSec())) {
        measured_at = pose->at;
        if (!std::exchange(pose->answered, true)) trips_.push_back(now - pose->at);
      }
    }
    governor_.take({{force.x, force.y, force.z}, {torque.x, torque.y, torque.z}}, measured_at, now);
  }

  void take_model(const std_msgs::Float64MultiArray& message) {
    namespace messages = palpate_client::messages;
    const double now = steady();
    double measured_at = kNever;
    {
      const std::scoped_lock lock(mutex_);
      ++models_;
      if (const Sent* pose = find(messages::measured_at(message.data))) measured_at = pose->at;
    }
    governor_.take_model(messages::local_model(message.data), measured_at, now);
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
  std::mutex mutex_;       // of what follows
  std::deque<Sent> sent_;  // of the last second
  std::vector<double> trips_;
  double wrench_ = 0.0;
  int count_ = 0, wrenches_ = 0, lost_ = 0, models_ = 0;
  std::uint32_t number_ = 0;  // of the newest wrench
};

/// Prints once a second, on a thread of its own: a terminal that takes no text would hold up the motors.
class Display {
 public:
  explicit Display(Driver& driver) : thread_([this, &driver] { print(driver); }) {}
  ~Display() {
    ends_ = true;
    thread_.join();
  }
  void tell(double z, double force) noexcept {
    z_ = z;
    force_ = force;
  }

 private:
  void print(Driver& driver) {
    for (int k = 1; !ends_; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      if (k % 10 != 0) continue;
      std::printf("z %.5f m, shown %.3f N, %s\n", z_.load(), force_.load(), driver.summary().c_str());
      std::fflush(stdout);
    }
  }

  std::atomic<double> z_ = 0.0, force_ = 0.0;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

/// Presses on what is below `aim`, from above it.
void press(Driver& driver, const Vector& aim) {
  Handle handle{aim[2] + kAbove, aim[2] + kAbove};
  Display display(driver);
  Motors motors;
  const auto begin = std::chrono::steady_clock::now();
  // From the end on no pose is sent: the force falls to zero, 100 ms after the last pose at the latest.
  // Leaving at once would leave the motors at the force of the last tick.
  int falls = 0;
  for (int k = 0; falls == 0 || motors.force() != 0.0; ++k) {
    if (falls > 0 || ends != 0 || !ros::ok()) ++falls;
    // A second and a half above, in which the gates open.
    handle.move(k < 1500 ? aim[2] + kAbove : aim[2], motors.force());
    const Vector position{aim[0], aim[1], handle.z};
    motors.show(driver.force(position));
    if (falls == 0) driver.send(position);
    display.tell(handle.z, motors.force());
    std::this_thread::sleep_until(begin + std::chrono::milliseconds(k + 1));
  }
  std::printf("fell to %.3f N in %d ms\n", motors.force(), falls);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    ros::init(argc, argv, "local_driver",
              ros::init_options::AnonymousName | ros::init_options::NoSigintHandler);
    if (argc != 5 && argc != 6) {
      std::fprintf(stderr, "usage: local_driver PREFIX X Y Z [wrench|local]\n");
      return 2;
    }
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, [](int) { ends = 1; });
    const bool local = argc == 5 || std::strcmp(argv[5], "local") == 0;
    Driver driver(argv[1], local);
    ros::AsyncSpinner spinner(1);
    spinner.start();
    press(driver, {std::atof(argv[2]), std::atof(argv[3]), std::atof(argv[4])});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "local_driver: %s\n", error.what());
    return 1;
  }
  return 0;
}

/// \file
/// Topics of a CRTK device on ROS 1. Includes no ROS headers, which do not compile as C++20.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace palpate::ros1 {

/// Header of a received message.
struct Header {
  double stamp = 0.0;  ///< 0 if there is none, NaN if it is invalid. Unit: [s].
  std::string frame;   ///< frame_id
  std::string source;  ///< name of the publishing node
};

/// Receiver of messages. Called by the link's thread, one message at a time.
class Listener {
 public:
  virtual ~Listener() = default;
  /// Called first, before the link connects: sets the scheduling of the link's thread, which threads of
  /// roscpp that it starts inherit.
  virtual void on_thread() = 0;
  /// \param position Unit: [m]. \param orientation w, x, y, z
  virtual void on_pose(const Header& header, const std::array<double, 3>& position,
                       const std::array<double, 4>& orientation) = 0;
  /// \param linear Unit: [m/s]. \param angular Unit: [rad/s].
  virtual void on_velocity(const Header& header, const std::array<double, 3>& linear,
                           const std::array<double, 3>& angular) = 0;
  /// \param header stamped by the publisher's clock when it answered echo `number`
  virtual void on_echo(std::uint64_t number, const Header& header) = 0;
  /// Called whenever the master has been asked which other node publishes wrenches for the device. \param
  /// name empty: none. Any thread of the link.
  virtual void on_other_writer(const std::string& name) = 0;
  /// Reports one line to the user. Any thread of the link.
  virtual void say(const std::string& line) = 0;
};

/// A wrench to publish.
struct StampedWrench {
  double stamp = 0.0;  ///< Unit: [s].
  std::array<double, 3> force{}, torque{};
};

/// Subscribes PREFIX/measured_cp, measured_cv and palpate/echoed, publishes PREFIX/spatial/servo_cf,
/// body/servo_cf, palpate/echo and palpate/local_model; all may be remapped. Connects as soon as there is a
/// master, and registers again after the master has restarted. Of several links in a process, one reports it.
/// If it is the link that initialises ROS, a request to end the node (`rosnode kill`) raises SIGTERM.
class Link {
 public:
  /// Starts the link without waiting for a master. `listener` must outlive it. \throws std::runtime_error if
  /// ROS cannot be initialised.
  Link(const std::string& prefix, Listener& listener);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// \name One thread. Nothing is sent until the link is connected
  /// @{
  /// \param spatial in the frame `frame` \param body in the handle's frame
  void publish(const StampedWrench& spatial, const std::string& frame, const StampedWrench& body);
  /// Returns whether either wrench has subscribers.
  bool has_listener() const;
  /// Returns how many subscribers of the wrenches and of the local model have come, at least; it grows with
  /// each.
  std::uint64_t arrivals();
  /// Publishes `number` as `seq` of a std_msgs/Header; the peer answers with its own time as stamp.
  void publish_echo(std::uint64_t number);
  /// \param numbers `head` numbers, then rows of `row` numbers
  void publish_local_model(const std::vector<double>& numbers, std::size_t head, std::size_t row);
  /// Returns whether the local model has subscribers.
  bool wants_local_model() const;
  /// @}

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace palpate::ros1

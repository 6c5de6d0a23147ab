/// \file
/// Topics of a CRTK device on ROS 1, without ROS headers: these do not compile as C++20.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace palpate::ros1 {

/// Header of a message that came.
struct Header {
  double stamp = 0.0;  ///< Unit: [s]. 0: none.
  std::string frame;   ///< frame_id
  std::string source;  ///< name of the node that publishes
};

/// Who gets what comes. Called by the link's thread, one message at a time.
class Listener {
 public:
  virtual ~Listener() = default;
  /// \param position Unit: [m]. \param orientation w, x, y, z
  virtual void on_pose(const Header& header, const std::array<double, 3>& position,
                       const std::array<double, 4>& orientation) = 0;
  /// \param linear Unit: [m/s]. \param angular Unit: [rad/s].
  virtual void on_velocity(const Header& header, const std::array<double, 3>& linear,
                           const std::array<double, 3>& angular) = 0;
  /// \param header with the stamp of the publisher's clock when it answered `number`
  virtual void on_echo(std::uint64_t number, const Header& header) = 0;
  /// One line for a person. Any thread of the link.
  virtual void say(const std::string& line) = 0;
};

/// A wrench to publish.
struct StampedWrench {
  double stamp = 0.0;  ///< Unit: [s].
  std::array<double, 3> force{}, torque{};
};

/// Subscribes PREFIX/measured_cp, measured_cv and palpate/echoed, publishes PREFIX/spatial/servo_cf,
/// body/servo_cf, palpate/echo and palpate/local_model; all may be remapped. Connects as soon as there is a
/// master, and registers anew where that has been started again; of several links in a process one tells it.
class Link {
 public:
  /// Begins; does not wait for a master. `listener` must outlive it. \throws std::runtime_error if ROS cannot
  /// be initialised.
  Link(const std::string& prefix, Listener& listener);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// \name One thread. Nothing is sent before there is a master
  /// @{
  /// \param spatial in the frame of the newest pose \param body in the handle's
  void publish(const StampedWrench& spatial, const StampedWrench& body);
  /// A std_msgs/Header: `seq` is to be answered, with the publisher's time as stamp.
  void publish_echo(std::uint64_t number);
  /// \param numbers the first `head` of them, then rows of `row`
  void publish_local_model(const std::vector<double>& numbers, std::size_t head, std::size_t row);
  /// Whether anybody gets it.
  bool wants_local_model() const;
  /// @}

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace palpate::ros1

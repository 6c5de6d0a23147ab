#include "ros1_transport.h"

#include <algorithm>

#include <palpate/base/real_time.h>

#include "ros_link.h"

namespace palpate {
namespace {

ros1::StampedWrench message_of(const Wrench& wrench, double stamp) {
  ros1::StampedWrench out{stamp, {}, {}};
  std::copy_n(wrench.force.data(), 3, out.force.begin());
  std::copy_n(wrench.torque.data(), 3, out.torque.begin());
  return out;
}

class Ros1Transport final : public CrtkTransport, public ros1::Listener {
 public:
  Ros1Transport(std::string prefix, std::function<void(const std::string&)> say)
      : prefix_(std::move(prefix)), say_(std::move(say)) {}

  void start(CrtkDevice& device) override {
    device_ = &device;
    link_ = std::make_unique<ros1::Link>(prefix_, *this);
  }
  void stop() noexcept override { link_.reset(); }
  void send(const CrtkWrench& wrench, const std::string& frame) override {
    link_->publish(message_of(wrench.spatial, wrench.stamp), frame, message_of(wrench.body, wrench.stamp));
  }
  bool has_listener() override { return link_->has_listener(); }
  std::uint64_t arrivals() override { return link_->arrivals(); }
  bool wants_local_model() override { return link_->wants_local_model(); }
  void send_local_model(const LocalModel& model, double stamp) override {
    link_->publish_local_model(numbers_of(model, stamp), kLocalModelHead, kLocalModelPlane);
  }
  void send_echo(std::uint64_t number) override { link_->publish_echo(number); }
  void say(const std::string& line) override { say_(line); }

 private:
  void on_thread() override {
    name_thread("palpate-ros1");
    make_real_time(kNetworkPriority);  // the servo loop reports why it is not permitted
  }
  void on_pose(const ros1::Header& header, const std::array<double, 3>& position,
               const std::array<double, 4>& orientation) override {
    Pose pose;
    pose.position = {position[0], position[1], position[2]};
    pose.orientation = {orientation[0], orientation[1], orientation[2], orientation[3]};
    device_->take_pose({header.stamp, header.frame, header.source}, pose);
  }
  void on_velocity(const ros1::Header& header, const std::array<double, 3>& linear,
                   const std::array<double, 3>& angular) override {
    Twist twist;
    twist.linear = {linear[0], linear[1], linear[2]};
    twist.angular = {angular[0], angular[1], angular[2]};
    device_->take_velocity({header.stamp, header.frame, header.source}, twist);
  }
  void on_echo(std::uint64_t number, const ros1::Header& header) override {
    device_->take_echo(number, {header.stamp, header.frame, header.source});
  }
  void on_other_writer(const std::string& name) override { device_->set_other_writer(name); }

  std::string prefix_;
  std::function<void(const std::string&)> say_;
  CrtkDevice* device_ = nullptr;
  std::unique_ptr<ros1::Link> link_;
};

}  // namespace

std::unique_ptr<CrtkTransport> make_ros1_transport(std::string prefix,
                                                   std::function<void(const std::string&)> say) {
  return std::make_unique<Ros1Transport>(std::move(prefix), std::move(say));
}

}  // namespace palpate

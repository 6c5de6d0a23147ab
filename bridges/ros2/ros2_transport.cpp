#include "ros2_transport.h"

#include <array>
#include <charconv>
#include <thread>

#include <palpate/base/error.h>
#include <palpate/base/real_time.h>

#include "dds_time.h"
#include "other_writers.h"
#include "ros_messages.h"
#include "take_all.h"

namespace palpate::ros2 {
namespace {

using Pose_ = geometry_msgs_msg_dds__PoseStamped_;
using Twist_ = geometry_msgs_msg_dds__TwistStamped_;
using Wrench_ = geometry_msgs_msg_dds__WrenchStamped_;
using Header_ = std_msgs_msg_dds__Header_;
using Array_ = std_msgs_msg_dds__Float64MultiArray_;
using Dimension_ = std_msgs_msg_dds__MultiArrayDimension_;

Eigen::Vector3d vector_of(const geometry_msgs_msg_dds__Vector3_& v) { return {v.x, v.y, v.z}; }
geometry_msgs_msg_dds__Vector3_ vector_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

class Ros2Transport final : public CrtkTransport {
 public:
  Ros2Transport(std::string prefix, Say say, Resolve resolve, Participant* participant)
      : prefix_(std::move(prefix)),
        say_(std::move(say)),
        resolve_(std::move(resolve)),
        participant_(participant) {}
  ~Ros2Transport() override { stop(); }

  void start(CrtkDevice& device) override {
    device_ = &device;
    if (participant_ == nullptr) {
      own_ = std::make_unique<Participant>(say_);
      participant_ = own_.get();
    }
    poses_ = reader("/measured_cp", geometry_msgs_msg_dds__PoseStamped__desc);
    velocities_ = reader("/measured_cv", geometry_msgs_msg_dds__TwistStamped__desc);
    echoes_ = reader("/palpate/echoed", std_msgs_msg_dds__Header__desc);
    spatial_ = writer("/spatial/servo_cf", geometry_msgs_msg_dds__WrenchStamped__desc);
    body_ = writer("/body/servo_cf", geometry_msgs_msg_dds__WrenchStamped__desc);
    echo_ = writer("/palpate/echo", std_msgs_msg_dds__Header__desc);
    local_model_ = writer("/palpate/local_model", std_msgs_msg_dds__Float64MultiArray__desc);
    others_ = std::make_unique<OtherWriters>(
        *participant_, std::vector{topic(prefix_ + "/spatial/servo_cf"), topic(prefix_ + "/body/servo_cf")},
        std::vector{spatial_, body_});
    set_ = checked(dds_create_waitset(participant_->id()), "wait for messages");
    end_ = checked(dds_create_guardcondition(participant_->id()), "wait for messages");
    for (const dds_entity_t entity : {poses_, velocities_, echoes_, others_->news(), end_}) {
      if (entity != end_)
        checked(dds_set_status_mask(entity, DDS_DATA_AVAILABLE_STATUS), "wait for messages");
      checked(dds_waitset_attach(set_, entity, entity), "wait for messages");
    }
    thread_ = std::thread([this] { run(); });
  }

  void stop() noexcept override {
    if (!thread_.joinable()) return;
    dds_set_guardcondition(end_, true);
    thread_.join();
    others_.reset();
    for (const dds_entity_t entity :
         {poses_, velocities_, echoes_, spatial_, body_, echo_, local_model_, set_, end_})
      dds_delete(entity);
    if (own_) participant_ = nullptr;
    own_.reset();
  }

  void send(const CrtkWrench& wrench, const std::string& frame) override {
    write(spatial_, wrench.spatial, wrench.stamp, frame);
    write(body_, wrench.body, wrench.stamp, "tool");
  }

  bool has_listener() override { return is_matched(spatial_) || is_matched(body_); }
  std::uint64_t arrivals() override { return matches(spatial_) + matches(body_) + matches(local_model_); }
  bool wants_local_model() override { return is_matched(local_model_); }
  void send_local_model(const LocalModel& model, double stamp) override {
    if (!wants_local_model()) return;
    std::vector<double> numbers = numbers_of(model, stamp);
    std::array<std::string, 2> labels{"planes", "point, normal"};
    const auto count = static_cast<std::uint32_t>(numbers.size()),
               planes = count - static_cast<std::uint32_t>(kLocalModelHead);
    constexpr auto kRow = static_cast<std::uint32_t>(kLocalModelPlane);
    std::array<Dimension_, 2> dimensions{
        {{labels[0].data(), planes / kRow, planes}, {labels[1].data(), kRow, kRow}}};
    const Array_ message{{{2, 2, dimensions.data(), false}, static_cast<std::uint32_t>(kLocalModelHead)},
                         {count, count, numbers.data(), false}};
    dds_write(local_model_, &message);
  }
  void send_echo(std::uint64_t number) override {
    std::string text = std::to_string(number);
    const Header_ echo{time_of(now()), text.data()};
    dds_write(echo_, &echo);
  }

  void say(const std::string& line) override { say_(line); }

 private:
  dds_entity_t reader(const char* name, const dds_topic_descriptor_t& type) {
    return participant_->make_reader("rt", resolve_(prefix_ + name), type, kSensor);
  }
  std::string topic(const std::string& name) const { return "rt" + resolve_(name); }
  dds_entity_t writer(const char* name, const dds_topic_descriptor_t& type) {
    return participant_->make_writer("rt", resolve_(prefix_ + name), type, kNewest);
  }

  static void write(dds_entity_t to, const Wrench& wrench, double stamp, std::string frame) {
    const Wrench_ message{{time_of(stamp), frame.data()},
                          {vector_of(wrench.force), vector_of(wrench.torque)}};
    dds_write(to, &message);
  }

  void run() {
    name_thread("palpate-ros2");
    make_real_time(kNetworkPriority);  // the servo loop reports why it is not permitted
    std::array<dds_attach_t, 5> triggered{};
    while (!ends()) {
      dds_waitset_wait(set_, triggered.data(), triggered.size(), DDS_INFINITY);
      device_->set_other_writer(others_->update());
      take_all<Pose_>(
          poses_, [this](const Pose_& message, dds_instance_handle_t writer) { take_pose(message, writer); });
      take_all<Twist_>(velocities_, [this](const Twist_& message, dds_instance_handle_t writer) {
        const Twist twist{vector_of(message.twist.linear), vector_of(message.twist.angular)};
        device_->take_velocity(header_of(velocities_, message.header, writer), twist);
      });
      take_all<Header_>(echoes_, [this](const Header_& message, dds_instance_handle_t writer) {
        take_echo(message, writer);
      });
    }
  }

  bool ends() const {
    bool triggered = false;
    return dds_read_guardcondition(end_, &triggered) < 0 || triggered;
  }

  void take_pose(const Pose_& message, dds_instance_handle_t writer) {
    const auto& [p, q] = message.pose;
    Pose pose;
    pose.position = {p.x, p.y, p.z};
    pose.orientation = {q.w, q.x, q.y, q.z};
    device_->take_pose(header_of(poses_, message.header, writer), pose);
  }

  void take_echo(const Header_& message, dds_instance_handle_t writer) {
    const std::string_view text(message.frame_id);
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error == std::errc() && end == text.data() + text.size())
      device_->take_echo(number, header_of(echoes_, message, writer));
  }

  /// Header with the source of the message, cached per reader. The source is the participant: poses and
  /// velocities of one process come from different writers.
  CrtkHeader header_of(dds_entity_t reader, const Header_& header, dds_instance_handle_t writer) {
    Source& source = reader == poses_        ? pose_source_
                     : reader == velocities_ ? velocity_source_
                                             : echo_source_;
    if (source.writer != writer) source = {writer, source_of(reader, writer)};
    return {seconds_of(header.stamp), header.frame_id, source.name};
  }

  struct Source {
    dds_instance_handle_t writer = 0;
    std::string name;
  };

  std::string prefix_;
  Say say_;
  Resolve resolve_;
  std::unique_ptr<Participant> own_;
  Participant* participant_;
  std::unique_ptr<OtherWriters> others_;  ///< of wrenches for the device
  CrtkDevice* device_ = nullptr;
  dds_entity_t poses_ = 0, velocities_ = 0, echoes_ = 0, spatial_ = 0, body_ = 0, echo_ = 0, local_model_ = 0;
  dds_entity_t set_ = 0, end_ = 0;  ///< wait set, and the guard condition that ends the thread
  Source pose_source_, velocity_source_, echo_source_;  ///< of the newest messages; transport's thread
  std::thread thread_;
};

}  // namespace

std::unique_ptr<CrtkTransport> make_transport(std::string prefix, Say say, Resolve resolve,
                                              Participant* participant) {
  return std::make_unique<Ros2Transport>(std::move(prefix), std::move(say), std::move(resolve), participant);
}

}  // namespace palpate::ros2

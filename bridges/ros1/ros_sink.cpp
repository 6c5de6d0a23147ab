#include "ros_sink.h"

#include <cstring>
#include <stdexcept>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/callback_queue.h>
#include <ros/master.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

namespace palpate::ros1 {
namespace {

constexpr const char* kWorld = "world";

template <class Out>
Out xyz(const Vector3& v) {
  Out out;
  out.x = v[0];
  out.y = v[1];
  out.z = v[2];
  return out;
}

geometry_msgs::Quaternion quaternion(const std::array<double, 4>& q) {
  geometry_msgs::Quaternion out;
  out.w = q[0];
  out.x = q[1];
  out.y = q[2];
  out.z = q[3];
  return out;
}

std_msgs::Header header(const std::string& frame) {
  std_msgs::Header out;
  out.stamp = ros::Time::now();
  out.frame_id = frame;
  return out;
}

visualization_msgs::Marker message_of(const SinkMarker& marker, const std_msgs::Header& head) {
  visualization_msgs::Marker out;
  out.header = head;
  out.ns = marker.ns;
  out.id = marker.id;
  out.type = marker.type;
  out.action = marker.action;
  out.pose.position = xyz<geometry_msgs::Point>(marker.pose.position);
  out.pose.orientation = quaternion(marker.pose.orientation);
  out.scale = xyz<geometry_msgs::Vector3>(marker.scale);
  out.color.r = static_cast<float>(marker.color[0]);
  out.color.g = static_cast<float>(marker.color[1]);
  out.color.b = static_cast<float>(marker.color[2]);
  out.color.a = static_cast<float>(marker.color[3]);
  for (const Vector3& point : marker.points) out.points.push_back(xyz<geometry_msgs::Point>(point));
  return out;
}

visualization_msgs::MarkerArray array_of(const std::vector<SinkMarker>& markers) {
  visualization_msgs::MarkerArray out;
  const std_msgs::Header head = header(kWorld);
  for (const SinkMarker& marker : markers) out.markers.push_back(message_of(marker, head));
  return out;
}

sensor_msgs::PointField field(const char* name, std::uint32_t offset) {
  sensor_msgs::PointField out;
  out.name = name;
  out.offset = offset;
  out.datatype = sensor_msgs::PointField::FLOAT32;
  out.count = 1;
  return out;
}

}  // namespace

bool init_node(int& argc, char** argv, NodeParameters& parameters) {
  try {
    ros::init(argc, argv, "palpate", ros::init_options::NoRosout);
    bool said = false;
    while (!ros::master::check()) {
      if (!ros::ok()) return false;
      if (!said) ROS_WARN("there is no ROS master at %s; it is waited for", ros::master::getURI().c_str());
      said = true;
      ros::WallDuration(0.2).sleep();
    }
    const ros::NodeHandle own("~");
    own.param<std::string>("scene", parameters.scene, "");
    own.param<std::string>("config", parameters.config, "");
    own.param<std::string>("device", parameters.device, "/omni");
    own.param("cloud_decimation", parameters.decimation, 1);
  } catch (const ros::Exception& error) {
    throw std::runtime_error(error.what());
  }
  if (parameters.decimation < 1) throw std::runtime_error("~cloud_decimation must be 1 or more");
  return true;
}

bool is_ok() { return ros::ok(); }

class Sink::Implementation {
 public:
  explicit Implementation(SinkServices services) : services_(std::move(services)) {
    contacts_ = node_.advertise<visualization_msgs::MarkerArray>("palpate/contacts", 2);
    tool_ = node_.advertise<visualization_msgs::MarkerArray>("palpate/tool", 2);
    transforms_ = node_.advertise<tf2_msgs::TFMessage>("/tf", 10);
    diagnostics_ = node_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 2);
    centers_ = node_.advertise<sensor_msgs::PointCloud2>("palpate/centers", 1, true);
    trigger("palpate/emergency_stop", services_.emergency_stop);
    trigger("palpate/resume", services_.resume);
    set_bool("palpate/pause", services_.pause);
    set_bool("palpate/clutch", services_.clutch);
    spinner_.start();
  }

  ros::Publisher contacts_, tool_, transforms_, diagnostics_, centers_;

 private:
  void trigger(const char* name, const std::function<void()>& work) {
    using Request = std_srvs::Trigger::Request;
    using Response = std_srvs::Trigger::Response;
    const boost::function<bool(Request&, Response&)> answer = [&work](Request&, Response& response) {
      work();
      response.success = 1;
      return true;
    };
    servers_.push_back(node_.advertiseService<Request, Response>(name, answer));
  }
  void set_bool(const char* name, const std::function<void(bool)>& work) {
    using Request = std_srvs::SetBool::Request;
    using Response = std_srvs::SetBool::Response;
    const boost::function<bool(Request&, Response&)> answer = [&work](Request& request, Response& response) {
      work(request.data != 0);
      response.success = 1;
      return true;
    };
    servers_.push_back(node_.advertiseService<Request, Response>(name, answer));
  }

  SinkServices services_;
  ros::NodeHandle node_;
  std::vector<ros::ServiceServer> servers_;
  ros::AsyncSpinner spinner_{1};
};

Sink::Sink(SinkServices services) : implementation_(std::make_unique<Implementation>(std::move(services))) {}
Sink::~Sink() = default;

void Sink::publish_contacts(const std::vector<SinkMarker>& markers) {
  if (!markers.empty()) implementation_->contacts_.publish(array_of(markers));
}
void Sink::publish_tool(const std::vector<SinkMarker>& markers) {
  implementation_->tool_.publish(array_of(markers));
}

void Sink::publish_transforms(const std::vector<SinkTransform>& transforms) {
  tf2_msgs::TFMessage message;
  for (const SinkTransform& transform : transforms) {
    geometry_msgs::TransformStamped out;
    out.header = header(transform.parent);
    out.child_frame_id = transform.child;
    out.transform.translation = xyz<geometry_msgs::Vector3>(transform.pose.position);
    out.transform.rotation = quaternion(transform.pose.orientation);
    message.transforms.push_back(out);
  }
  implementation_->transforms_.publish(message);
}

void Sink::publish_status(const SinkStatus& status) {
  diagnostic_msgs::DiagnosticArray message;
  message.header = header("");
  diagnostic_msgs::DiagnosticStatus out;
  out.level = static_cast<std::int8_t>(status.level);
  out.name = "palpate: servo";
  out.message = status.message;
  for (const auto& [key, value] : status.values) {
    diagnostic_msgs::KeyValue pair;
    pair.key = key;
    pair.value = value;
    out.values.push_back(pair);
  }
  message.status.push_back(out);
  implementation_->diagnostics_.publish(message);
}

void Sink::publish_centers(const std::vector<float>& points) {
  constexpr std::uint32_t kStep = 3 * sizeof(float);
  sensor_msgs::PointCloud2 message;
  message.header = header(kWorld);
  message.height = 1;
  message.width = static_cast<std::uint32_t>(points.size() / 3);
  message.fields = {field("x", 0), field("y", 4), field("z", 8)};
  message.point_step = kStep;
  message.row_step = kStep * message.width;
  message.data.resize(message.row_step);
  if (!points.empty()) std::memcpy(message.data.data(), points.data(), message.data.size());
  message.is_dense = 1;
  implementation_->centers_.publish(message);
}

}  // namespace palpate::ros1

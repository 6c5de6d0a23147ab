#include "ros_sink.h"

#include <array>
#include <cstring>
#include <optional>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/callback_queue.h>
#include <ros/connection_manager.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <ros/this_node.h>
#include <ros/xmlrpc_manager.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/String.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

#include "master_watch.h"

namespace palpate::ros1 {
namespace {

using node::Answer;
using node::Pace;
using node::SinkMarker;
using node::SinkStatus;
using node::SinkTransform;
using node::Vector3;

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

visualization_msgs::MarkerArray array_of(const std::vector<SinkMarker>& markers, const std::string& frame) {
  visualization_msgs::MarkerArray out;
  const std_msgs::Header head = header(frame);
  for (const SinkMarker& marker : markers) out.markers.push_back(message_of(marker, head));
  return out;
}

diagnostic_msgs::DiagnosticStatus message_of(const SinkStatus& status) {
  diagnostic_msgs::DiagnosticStatus out;
  out.level = static_cast<std::int8_t>(status.level);
  out.name = status.name;
  out.message = status.message;
  out.hardware_id = status.hardware_id;
  for (const auto& [key, value] : status.values) {
    diagnostic_msgs::KeyValue pair;
    pair.key = key;
    pair.value = value;
    out.values.push_back(pair);
  }
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

sensor_msgs::PointCloud2 cloud_of(const std::vector<float>& points, const std::string& frame) {
  constexpr std::uint32_t kStep = 3 * sizeof(float);
  sensor_msgs::PointCloud2 out;
  out.header = header(frame);
  out.height = 1;
  out.width = static_cast<std::uint32_t>(points.size() / 3);
  out.fields = {field("x", 0), field("y", 4), field("z", 8)};
  out.point_step = kStep;
  out.row_step = kStep * out.width;
  out.data.resize(out.row_step);
  if (!points.empty()) std::memcpy(out.data.data(), points.data(), out.data.size());
  out.is_dense = 1;
  return out;
}

template <class Response>
bool respond(const Answer& answer, Response& response) {
  response.success = answer.success ? 1 : 0;
  response.message = answer.message;
  return true;
}

class Ros1Sink final : public node::NodeSink {
 public:
  Ros1Sink(std::string world, std::vector<node::SinkHand> hands)
      : world_(std::move(world)), hands_(std::move(hands)) {
    // Separate queues: Link serves the queue of the device.
    for (Served& served : served_) served.node.setCallbackQueue(&served.queue);
    for (const node::SinkHand& hand : hands_) {
      contacts_.push_back(node_.advertise<visualization_msgs::MarkerArray>(hand.prefix + "/contacts", 2));
      tools_.push_back(node_.advertise<visualization_msgs::MarkerArray>(hand.prefix + "/tool", 2));
      for (const Pace pace : node::kPaces)
        node::make_listeners(hand, pace,
                             [&](const auto& name, const auto& work) { listen(node_of(pace), name, work); });
    }
    transforms_ = node_.advertise<tf2_msgs::TFMessage>("/tf", 10);
    diagnostics_ = node_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 2);
    centers_ = node_.advertise<sensor_msgs::PointCloud2>("palpate/centers", 1, true);
    serve();
    for (Served& served : served_) served.spinner.start();
    watch_.emplace([] {}, [] {}, [this](const MasterState& state) { register_missing(state); });
  }

  ~Ros1Sink() override {
    for (Served& served : served_) served.spinner.stop();
  }

  bool wants_contacts(std::size_t hand) const override { return contacts_[hand].getNumSubscribers() > 0; }
  void publish_contacts(std::size_t hand, const std::vector<SinkMarker>& markers) override {
    contacts_[hand].publish(array_of(markers, world_));
  }
  void publish_tool(std::size_t hand, const std::vector<SinkMarker>& markers) override {
    tools_[hand].publish(array_of(markers, world_));
  }
  void publish_centers(const std::vector<float>& points) override {
    centers_.publish(cloud_of(points, world_));
  }

  void publish_transforms(const std::vector<SinkTransform>& transforms) override {
    tf2_msgs::TFMessage message;
    for (const SinkTransform& transform : transforms) {
      geometry_msgs::TransformStamped out;
      out.header = header(world_);
      out.child_frame_id = transform.child;
      out.transform.translation = xyz<geometry_msgs::Vector3>(transform.pose.position);
      out.transform.rotation = quaternion(transform.pose.orientation);
      message.transforms.push_back(out);
    }
    transforms_.publish(message);
  }

  void publish_diagnostics(const std::vector<SinkStatus>& statuses) override {
    diagnostic_msgs::DiagnosticArray message;
    message.header = header("");
    for (const SinkStatus& status : statuses) message.status.push_back(message_of(status));
    diagnostics_.publish(message);
  }

 private:
  /// What is served on a thread of its own.
  struct Served {
    ros::CallbackQueue queue;
    ros::NodeHandle node;
    ros::AsyncSpinner spinner{1, &queue};
  };

  ros::NodeHandle& node_of(Pace pace) { return served_[static_cast<std::size_t>(pace)].node; }
  void serve() {
    for (const node::SinkHand& hand : hands_)
      for (const Pace pace : node::kPaces)
        node::make_services(
            hand, pace, [&](const auto& name, const auto& work) { trigger(node_of(pace), name, work); },
            [&](const auto& name, const auto& work) { set_bool(node_of(pace), name, work); });
  }
  /// Registers the services that the master does not have, as after its restart. They stay up: calls go on,
  /// and connections persist. What fails is tried again at the next look.
  void register_missing(const MasterState& state) const {
    std::vector<std::string> missing;
    for (const ros::ServiceServer& server : servers_)
      if (server && state.services.count(server.getService()) == 0) missing.push_back(server.getService());
    if (missing.empty() || is_replaced()) return;
    XmlRpc::XmlRpcValue request, response, payload;
    request[0] = ros::this_node::getName();
    request[2] = "rosrpc://" + ros::network::getHost() + ":" +
                 std::to_string(ros::ConnectionManager::instance()->getTCPPort());
    request[3] = ros::XMLRPCManager::instance()->getServerURI();
    for (const std::string& service : missing) {
      request[1] = service;
      ros::master::execute("registerService", request, response, payload, false);
    }
  }
  void listen(ros::NodeHandle& node, const std::string& name,
              const std::function<void(const std::string&)>& work) {
    const boost::function<void(const std_msgs::String::ConstPtr&)> hear =
        [work](const std_msgs::String::ConstPtr& message) { work(message->data); };
    listeners_.push_back(node.subscribe<std_msgs::String>(name, 10, hear));
  }
  void trigger(ros::NodeHandle& node, const std::string& name, const std::function<Answer()>& work) {
    using Request = std_srvs::Trigger::Request;
    using Response = std_srvs::Trigger::Response;
    const boost::function<bool(Request&, Response&)> answer = [work](Request&, Response& response) {
      return respond(work(), response);
    };
    servers_.push_back(node.advertiseService<Request, Response>(name, answer));
  }
  void set_bool(ros::NodeHandle& node, const std::string& name, const std::function<Answer(bool)>& work) {
    using Request = std_srvs::SetBool::Request;
    using Response = std_srvs::SetBool::Response;
    const boost::function<bool(Request&, Response&)> answer = [work](Request& request, Response& response) {
      return respond(work(request.data != 0), response);
    };
    servers_.push_back(node.advertiseService<Request, Response>(name, answer));
  }

  std::string world_;
  std::vector<node::SinkHand> hands_;
  ros::NodeHandle node_;
  std::array<Served, node::kPaces.size()> served_;
  std::vector<ros::Publisher> contacts_, tools_;
  ros::Publisher transforms_, diagnostics_, centers_;
  std::vector<ros::ServiceServer> servers_;
  std::vector<ros::Subscriber> listeners_;
  /// Registers the services whenever the master does not have them; Link does so for topics. Started once all
  /// of them are advertised, each of which waits for the master.
  std::optional<MasterWatch> watch_;
};

}  // namespace

std::unique_ptr<node::NodeSink> make_sink(std::string world, std::vector<node::SinkHand> hands) {
  return std::make_unique<Ros1Sink>(std::move(world), std::move(hands));
}

}  // namespace palpate::ros1

#include "ros_link.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include <unistd.h>

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <ros/callback_queue.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/publication.h>
#include <ros/ros.h>
#include <ros/topic_manager.h>
#include <ros/xmlrpc_manager.h>
#include <std_msgs/Float64MultiArray.h>
#include <std_msgs/Header.h>

#include "end_request.h"
#include "master_watch.h"
#include "other_publisher.h"

namespace palpate::ros1 {
namespace {

/// Polling interval of the master and of the end. Unit: [s].
constexpr double kLook = 0.2;
/// Queue length of subscriptions; only the newest pose counts.
constexpr int kQueue = 8;
/// Type that the master takes for any; publishers tell it the true one.
constexpr const char* kAnyType = "*";

/// True once the loss of the master has been reported; one flag per process, shared by all links.
std::atomic<bool> lost{false};

/// How often a link has found that the master lacks topics of this process; shared by all links, since each
/// registers all topics.
std::atomic<unsigned> restarts{0};

/// Whether a link has initialised ROS, in a program that is no node otherwise.
std::atomic<bool> initialised{false};

/// Ends the program as SIGTERM does once its node is asked to end: the force falls first.
void end_with_node() {
  static std::once_flag once;
  if (initialised) std::call_once(once, [] { on_end_request([] { ::kill(::getpid(), SIGTERM); }); });
}

std_msgs::MultiArrayDimension dimension(const char* label, std::size_t size, std::size_t stride) {
  std_msgs::MultiArrayDimension out;
  out.label = label;
  out.size = static_cast<std::uint32_t>(size);
  out.stride = static_cast<std::uint32_t>(stride);
  return out;
}

std::array<double, 3> array_of(const geometry_msgs::Vector3& v) { return {v.x, v.y, v.z}; }

geometry_msgs::Vector3 vector_of(const std::array<double, 3>& v) {
  geometry_msgs::Vector3 out;
  out.x = v[0];
  out.y = v[1];
  out.z = v[2];
  return out;
}

/// Returns NaN for a stamp that is invalid, or whose nearest double is beyond the range of stamps.
double seconds_of(const ros::Time& stamp) {
  const bool valid = stamp.nsec < 1000000000U && stamp.sec < std::numeric_limits<std::uint32_t>::max();
  return valid ? stamp.toSec() : std::numeric_limits<double>::quiet_NaN();
}

template <class Message>
Header header_of(const ros::MessageEvent<const Message>& event) {
  const auto& head = event.getConstMessage()->header;
  return {seconds_of(head.stamp), head.frame_id, event.getPublisherName()};
}

}  // namespace

class Link::Implementation {
 public:
  Implementation(const std::string& prefix, Listener& listener) : prefix_(prefix), listener_(listener) {
    if (!ros::isInitialized()) {
      require_master_uri();
      int argc = 0;
      // No rosout: advertising it blocks until there is a master.
      ros::init(argc, nullptr, "palpate",
                ros::init_options::AnonymousName | ros::init_options::NoSigintHandler |
                    ros::init_options::NoRosout);
      initialised = true;
    }
    thread_ = std::thread([this] { run(); });
  }
  ~Implementation() {
    ends_ = true;
    thread_.join();
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  void publish(const StampedWrench& spatial, const std::string& frame, const StampedWrench& body) {
    if (!connected_.load(std::memory_order_acquire)) return;
    send(spatial_, spatial, frame);
    send(body_, body, "tool");
  }

  void publish_echo(std::uint64_t number) {
    if (!connected_.load(std::memory_order_acquire)) return;
    std_msgs::Header echo;
    echo.seq = static_cast<std::uint32_t>(number);
    echo.stamp = ros::Time::now();
    echo_.publish(echo);
  }

  bool has_listener() const {
    return connected_.load(std::memory_order_acquire) &&
           (spatial_.getNumSubscribers() > 0 || body_.getNumSubscribers() > 0);
  }

  /// Counts tell at once of whoever comes, but not if another leaves meanwhile; callbacks miss nobody, but
  /// wait in a queue.
  std::uint64_t arrivals() {
    if (!connected_.load(std::memory_order_acquire)) return arrivals_;
    const std::array<const ros::Publisher*, 3> topics{&spatial_, &body_, &local_model_};
    for (std::size_t k = 0; k < topics.size(); ++k) {
      const std::uint32_t before = std::exchange(counts_[k], topics[k]->getNumSubscribers());
      if (counts_[k] > before) arrivals_ += counts_[k] - before;
    }
    arrivals_ = std::max(arrivals_, came_.load(std::memory_order_relaxed));
    return arrivals_;
  }

  bool wants_local_model() const {
    return connected_.load(std::memory_order_acquire) && local_model_.getNumSubscribers() > 0;
  }

  void publish_local_model(const std::vector<double>& numbers, std::size_t head, std::size_t row) {
    if (!wants_local_model()) return;
    std_msgs::Float64MultiArray message;
    message.layout.data_offset = static_cast<std::uint32_t>(head);
    message.layout.dim = {dimension("planes", (numbers.size() - head) / row, numbers.size() - head),
                          dimension("point, normal", row, row)};
    message.data = numbers;
    local_model_.publish(message);
  }

 private:
  static void send(const ros::Publisher& to, const StampedWrench& wrench, const std::string& frame) {
    geometry_msgs::WrenchStamped message;
    message.header.stamp.fromSec(wrench.stamp);
    message.header.frame_id = frame;
    message.wrench.force = vector_of(wrench.force);
    message.wrench.torque = vector_of(wrench.torque);
    to.publish(message);
  }

  void run() {
    listener_.on_thread();
    while (!ends_ && !ros::master::check()) {
      tell_lost("there is no ROS master at " + ros::master::getURI() +
                "; start roscore, or set ROS_MASTER_URI");
      sleep();
    }
    if (ends_) return;
    tell_found();
    connect();
    watch_master();
    while (!ends_) queue_.callAvailable(ros::WallDuration(kLook));
    watch_.reset();
    subscriptions_ = {};
    connected_ = false;
  }

  void connect() {
    node_ = std::make_unique<ros::NodeHandle>(prefix_);
    end_with_node();
    node_->setCallbackQueue(&queue_);
    const ros::SubscriberStatusCallback come = [this](const auto&) { ++came_; };
    spatial_ = node_->advertise<geometry_msgs::WrenchStamped>("spatial/servo_cf", 1, come);
    body_ = node_->advertise<geometry_msgs::WrenchStamped>("body/servo_cf", 1, come);
    others_ = std::make_unique<OtherPublisher>(
        std::vector<std::string>{spatial_.getTopic(), body_.getTopic()},
        [this](const std::string& name) { listener_.on_other_writer(name); });
    if (const auto state = ask_master()) others_->update(*state, false);  // before the first pose
    const auto hints = ros::TransportHints().tcpNoDelay();
    subscriptions_ = {node_->subscribe<geometry_msgs::PoseStamped>(
                          "measured_cp", kQueue,
                          boost::function<void(const ros::MessageEvent<const geometry_msgs::PoseStamped>&)>(
                              [this](const auto& event) { take_pose(event); }),
                          ros::VoidConstPtr(), hints),
                      node_->subscribe<geometry_msgs::TwistStamped>(
                          "measured_cv", kQueue,
                          boost::function<void(const ros::MessageEvent<const geometry_msgs::TwistStamped>&)>(
                              [this](const auto& event) {
                                const auto& twist = event.getConstMessage()->twist;
                                listener_.on_velocity(header_of(event), array_of(twist.linear),
                                                      array_of(twist.angular));
                              }),
                          ros::VoidConstPtr(), hints),
                      node_->subscribe<std_msgs::Header>(
                          "palpate/echoed", kQueue,
                          boost::function<void(const ros::MessageEvent<const std_msgs::Header>&)>(
                              [this](const auto& event) { take_echo(event); }),
                          ros::VoidConstPtr(), hints)};
    echo_ = node_->advertise<std_msgs::Header>("palpate/echo", 1);
    local_model_ = node_->advertise<std_msgs::Float64MultiArray>("palpate/local_model", 1, come);
    connected_.store(true, std::memory_order_release);
  }

  void take_pose(const ros::MessageEvent<const geometry_msgs::PoseStamped>& event) {
    const geometry_msgs::PoseStamped& message = *event.getConstMessage();
    const auto& p = message.pose.position;
    const auto& q = message.pose.orientation;
    listener_.on_pose(header_of(event), {p.x, p.y, p.z}, {q.w, q.x, q.y, q.z});
  }

  void take_echo(const ros::MessageEvent<const std_msgs::Header>& event) {
    const std_msgs::Header& echo = *event.getConstMessage();
    listener_.on_echo(echo.seq, {seconds_of(echo.stamp), echo.frame_id, event.getPublisherName()});
  }

  void watch_master() {
    watch_ = std::make_unique<MasterWatch>(
        [this] { tell_lost("lost the ROS master; existing connections persist; waiting for it"); },
        [this] { tell_found(); },
        [this](const MasterState& state) {
          register_missing(state);
          const unsigned now = restarts;
          others_->update(state, std::exchange(restarts_, now) != now);
        });
  }

  /// Registers the topics of the process that the master does not have, as after its restart; connections
  /// persist. What fails is tried again at the next look.
  static void register_missing(const MasterState& state) {
    const std::string& self = ros::this_node::getName();
    const auto missing = [&self](std::vector<std::string> topics, const MasterState::Nodes& all) {
      topics.erase(std::remove_if(topics.begin(), topics.end(),
                                  [&](const std::string& topic) { return has(all, topic, self); }),
                   topics.end());
      return topics;
    };
    std::vector<std::string> subscribed, advertised;
    ros::this_node::getSubscribedTopics(subscribed);
    ros::this_node::getAdvertisedTopics(advertised);
    subscribed = missing(std::move(subscribed), state.subscribers);
    advertised = missing(std::move(advertised), state.publishers);
    if ((subscribed.empty() && advertised.empty()) || is_replaced()) return;
    ++restarts;  // before another link finds its topics registered
    for (const std::string& topic : subscribed)
      update(topic, register_as("registerSubscriber", topic, kAnyType));
    for (const std::string& topic : advertised)
      if (const auto publication = ros::TopicManager::instance()->lookupPublication(topic))
        register_as("registerPublisher", topic, publication->getDataType());
  }

  /// Registers one topic. \returns the master's answer: for a subscriber, the known publishers.
  static XmlRpc::XmlRpcValue register_as(const char* method, const std::string& topic,
                                         const std::string& type) {
    XmlRpc::XmlRpcValue request, response, payload;
    request[0] = ros::this_node::getName();
    request[1] = topic;
    request[2] = type;
    request[3] = ros::XMLRPCManager::instance()->getServerURI();
    ros::master::execute(method, request, response, payload, false);
    return payload;
  }

  /// Passes publishers that registered earlier to this node's own server, as the master does for later ones.
  static void update(const std::string& topic, const XmlRpc::XmlRpcValue& publishers) {
    if (publishers.getType() != XmlRpc::XmlRpcValue::TypeArray || publishers.size() == 0) return;
    std::string host;
    std::uint32_t port = 0;
    if (!ros::network::splitURI(ros::XMLRPCManager::instance()->getServerURI(), host, port)) return;
    XmlRpc::XmlRpcValue request, response;
    request[0] = "/master";
    request[1] = topic;
    request[2] = publishers;
    XmlRpc::XmlRpcClient(host.c_str(), static_cast<int>(port), "/")
        .execute("publisherUpdate", request, response);
  }

  void tell_lost(const std::string& line) {
    if (!lost.exchange(true)) listener_.say(line);
  }
  void tell_found() {
    if (lost.exchange(false)) listener_.say("connected to the ROS master");
  }
  static void sleep() { std::this_thread::sleep_for(std::chrono::duration<double>(kLook)); }

  std::string prefix_;
  Listener& listener_;
  ros::CallbackQueue queue_;
  std::unique_ptr<ros::NodeHandle> node_;
  std::array<ros::Subscriber, 3> subscriptions_;  ///< poses, velocities, echoes
  ros::Publisher spatial_, body_, echo_, local_model_;
  std::array<std::uint32_t, 3> counts_{};  ///< subscribers of wrenches and local model
  std::uint64_t arrivals_ = 0;
  std::atomic<std::uint64_t> came_ = 0;
  std::atomic<bool> ends_ = false, connected_ = false;
  std::unique_ptr<OtherPublisher> others_;  ///< of wrenches for the device
  unsigned restarts_ = 0;                   ///< that others_ knows of
  std::unique_ptr<MasterWatch> watch_;
  std::thread thread_;
};

Link::Link(const std::string& prefix, Listener& listener) {
  try {
    implementation_ = std::make_unique<Implementation>(prefix, listener);
  } catch (const ros::Exception& error) {
    throw std::runtime_error(error.what());
  }
}
Link::~Link() = default;
void Link::publish(const StampedWrench& spatial, const std::string& frame, const StampedWrench& body) {
  implementation_->publish(spatial, frame, body);
}
void Link::publish_echo(std::uint64_t number) { implementation_->publish_echo(number); }
void Link::publish_local_model(const std::vector<double>& numbers, std::size_t head, std::size_t row) {
  implementation_->publish_local_model(numbers, head, row);
}
bool Link::has_listener() const { return implementation_->has_listener(); }
std::uint64_t Link::arrivals() { return implementation_->arrivals(); }
bool Link::wants_local_model() const { return implementation_->wants_local_model(); }

}  // namespace palpate::ros1

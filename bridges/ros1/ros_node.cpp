#include "ros_node.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <stdexcept>
#include <thread>

#include <unistd.h>

#include <ros/init.h>
#include <ros/master.h>
#include <ros/param.h>
#include <ros/this_node.h>

#include "end_request.h"
#include "master_watch.h"

namespace palpate::ros1 {
namespace {

using XmlRpc::XmlRpcValue;

std::atomic<bool> asked_to_end{false};

std::string text_of(const std::string& name, XmlRpcValue& value) {
  switch (value.getType()) {
    case XmlRpcValue::TypeString: return static_cast<std::string>(value);
    case XmlRpcValue::TypeBoolean: return static_cast<bool>(value) ? "true" : "false";
    case XmlRpcValue::TypeInt: return std::to_string(static_cast<int>(value));
    case XmlRpcValue::TypeDouble: {
      char text[32];
      std::snprintf(text, sizeof text, "%.17g", static_cast<double>(value));
      return text;
    }
    case XmlRpcValue::TypeArray: {
      std::string all;
      for (int i = 0; i < value.size(); ++i) all += (i > 0 ? "," : "") + text_of(name, value[i]);
      return all;
    }
    default:
      throw std::runtime_error("parameter '" + name +
                               "': must be a number, text, true, false or an array of these");
  }
}

void wait_for_master() {
  for (bool said = false; !ros::master::check(); said = true) {
    if (!said)
      std::fprintf(stderr,
                   "palpate_ros1: there is no ROS master at %s; waiting for it; start roscore, or set "
                   "ROS_MASTER_URI\n",
                   ros::master::getURI().c_str());
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
}

std::vector<node::NodeParameter> private_parameters() {
  const std::string prefix = ros::this_node::getName() + "/";
  std::vector<std::string> keys;
  if (!ros::param::getParamNames(keys))
    throw std::runtime_error("cannot read parameters from the ROS master; restart the node");
  std::vector<node::NodeParameter> all;
  for (const std::string& key : keys) {
    if (key.compare(0, prefix.size(), prefix) != 0) continue;
    const std::string name = key.substr(prefix.size());
    XmlRpcValue value;
    if (ros::param::get(key, value)) all.push_back({name, text_of(name, value)});
  }
  return all;
}

}  // namespace

std::vector<node::NodeParameter> init_node(int& argc, char** argv) {
  require_master_uri();
  try {
    // No rosout: advertising it blocks until there is a master.
    ros::init(argc, argv, "palpate", ros::init_options::NoSigintHandler | ros::init_options::NoRosout);
  } catch (const ros::Exception& error) {
    throw std::runtime_error(error.what());
  }
  if (argc > 1)
    throw std::runtime_error(
        std::string("'") + argv[1] +
        "' is not an argument; expected remappings FROM:=TO and parameters _NAME:=VALUE");
  wait_for_master();
  return private_parameters();
}

void start_node() {
  ros::start();
  // As SIGTERM does, whose handler begins to ramp the force down even while the main thread blocks, in a
  // scene or a disk. Once: a second signal may come when the node has ended its run, and would cut its end
  // short.
  on_end_request([] {
    if (!asked_to_end.exchange(true)) ::kill(::getpid(), SIGTERM);
  });
}

bool is_up() { return !asked_to_end && ros::ok(); }

}  // namespace palpate::ros1

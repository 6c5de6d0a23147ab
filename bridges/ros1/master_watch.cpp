#include "master_watch.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <utility>

#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <ros/xmlrpc_manager.h>
#include <xmlrpcpp/XmlRpcException.h>

namespace palpate::ros1 {
namespace {

constexpr std::chrono::milliseconds kLookEvery(200);

/// \param list [[name, [node, ...]], ...]
MasterState::Nodes nodes_of(XmlRpc::XmlRpcValue& list) {
  MasterState::Nodes all;
  for (int k = 0; k < list.size(); ++k) {
    std::vector<std::string>& nodes = all[static_cast<std::string>(list[k][0])];
    for (int n = 0; n < list[k][1].size(); ++n) nodes.push_back(static_cast<std::string>(list[k][1][n]));
  }
  return all;
}

}  // namespace

void require_master_uri() {
  // No code here sets environment variables. NOLINTNEXTLINE(concurrency-mt-unsafe)
  const char* uri = std::getenv("ROS_MASTER_URI");
  std::string host;
  std::uint32_t port = 0;
  if (uri == nullptr || *uri == '\0')
    throw std::runtime_error("ROS_MASTER_URI is not set; export ROS_MASTER_URI=http://HOST:11311");
  if (!ros::network::splitURI(uri, host, port))
    throw std::runtime_error("ROS_MASTER_URI is not of the form http://HOST:PORT");
}

bool has(const MasterState::Nodes& all, const std::string& name, const std::string& node) {
  const auto found = all.find(name);
  return found != all.end() && std::count(found->second.begin(), found->second.end(), node) > 0;
}

std::optional<MasterState> ask_master() {
  XmlRpc::XmlRpcValue request, response, state;
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, response, state, false)) return std::nullopt;
  try {
    return MasterState{nodes_of(state[0]), nodes_of(state[1]), nodes_of(state[2])};
  } catch (const XmlRpc::XmlRpcException&) {
    return std::nullopt;
  }
}

std::string uri_of(const std::string& node) {
  XmlRpc::XmlRpcValue request, response, uri;
  request[0] = ros::this_node::getName();
  request[1] = node;
  const bool known = ros::master::execute("lookupNode", request, response, uri, false) &&
                     uri.getType() == XmlRpc::XmlRpcValue::TypeString;
  return known ? static_cast<std::string>(uri) : std::string();
}

bool is_replaced() {
  const std::string uri = uri_of(ros::this_node::getName());
  return !uri.empty() && uri != ros::XMLRPCManager::instance()->getServerURI();
}

MasterWatch::MasterWatch(std::function<void()> lost, std::function<void()> found,
                         std::function<void(const MasterState&)> look)
    : lost_(std::move(lost)), found_(std::move(found)), look_(std::move(look)), thread_([this] { run(); }) {}

MasterWatch::~MasterWatch() {
  ends_ = true;
  thread_.join();
}

void MasterWatch::run() {
  bool gone = false;
  while (!ends_) {
    std::this_thread::sleep_for(kLookEvery);
    const std::optional<MasterState> state = ask_master();
    if (!state) {
      if (!gone) lost_();
      gone = true;
      continue;
    }
    if (std::exchange(gone, false)) found_();
    look_(*state);
  }
}

}  // namespace palpate::ros1

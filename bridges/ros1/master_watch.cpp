#include "master_watch.h"

#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>

namespace palpate::ros1 {
namespace {

constexpr std::chrono::milliseconds kLookEvery(200);

/// Process id of the master; 0 if it cannot be reached.
int master_pid() {
  XmlRpc::XmlRpcValue request, response, payload;
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getPid", request, response, payload, false)) return 0;
  return payload.getType() == XmlRpc::XmlRpcValue::TypeInt ? static_cast<int>(payload) : 0;
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

MasterWatch::MasterWatch(std::function<void()> lost, std::function<void(bool)> found,
                         std::function<void()> reached)
    : lost_(std::move(lost)),
      found_(std::move(found)),
      reached_(std::move(reached)),
      thread_([this] { run(); }) {}

MasterWatch::~MasterWatch() {
  ends_ = true;
  thread_.join();
}

void MasterWatch::run() {
  int known = 0;
  bool gone = false;
  while (!ends_) {
    std::this_thread::sleep_for(kLookEvery);
    const int pid = master_pid();
    if (pid == 0) {
      if (!gone) lost_();
      gone = true;
      continue;
    }
    const bool another = known != 0 && pid != known;
    if (gone || another) found_(another);
    gone = false;
    known = pid;
    reached_();
  }
}

}  // namespace palpate::ros1

/// \file
/// Detection of other publishers of a topic. Includes no ROS headers, which do not compile as C++20.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "master_watch.h"

namespace palpate::ros1 {

/// Finds the nodes other than this one that publish some topics, according to the master. A node that has
/// crashed stays registered: it counts unless its host refuses connections to its port; this host at a
/// loopback address, only if it has the name of this node's host, or this node is called by such an address.
/// A master that has restarted does not know nodes that do not register again: those that are known count
/// until their hosts refuse connections. One thread.
class OtherPublisher {
 public:
  /// \param topics resolved names, which this node publishes, too \param tell called by each update(), with
  /// the name of such a node; empty: none
  OtherPublisher(std::vector<std::string> topics, std::function<void(const std::string& name)> tell)
      : topics_(std::move(topics)), tell_(std::move(tell)) {}

  /// \param restarted whether the master has restarted since the last call, as far as is known; it has also
  /// if `state` lacks this node \pre ROS is initialised. Blocks: a node that is new is told before.
  void update(const MasterState& state, bool restarted);

 private:
  struct Node {
    std::string uri;
    bool listed = true;  ///< by the master
    bool ended = false;
  };
  void look_at_list(const MasterState& state, bool restarted);
  void tell() const;

  std::vector<std::string> topics_;
  std::function<void(const std::string&)> tell_;
  std::map<std::string, Node> known_;
};

}  // namespace palpate::ros1

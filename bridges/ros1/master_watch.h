/// \file
/// Monitoring of the ROS master. Includes no ROS headers, which do not compile as C++20.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace palpate::ros1 {

/// \throws std::runtime_error if ROS_MASTER_URI is not a valid URI; ROS itself would abort.
void require_master_uri();

/// Registrations that the master has. Those of a node that has crashed stay; one that has just started has
/// none, whatever runs.
struct MasterState {
  using Nodes = std::map<std::string, std::vector<std::string>>;  ///< names of nodes, by topic or service
  Nodes publishers, subscribers, services;
};

/// Returns whether `node` is among those of `name`.
bool has(const MasterState::Nodes& all, const std::string& name, const std::string& node);

/// Asks the master. \returns nothing if it does not answer. \pre ROS is initialised. Blocks.
std::optional<MasterState> ask_master();

/// Returns the URI of a node; empty if the master does not know it, or does not answer. \pre ROS is
/// initialised. Blocks.
std::string uri_of(const std::string& node);

/// Returns whether another node has taken the name of this one, which must then register nothing: the master
/// would end the other. \pre ROS is started. Blocks.
bool is_replaced();

/// Polls the master.
class MasterWatch {
 public:
  /// Starts polling. The callbacks run on its own thread. \param lost called once each time the master is
  /// lost \param found called when a master is reached again \param look called each time that the master
  /// answers, after `found` \pre ROS is initialised
  MasterWatch(std::function<void()> lost, std::function<void()> found,
              std::function<void(const MasterState&)> look);
  ~MasterWatch();
  MasterWatch(const MasterWatch&) = delete;
  MasterWatch& operator=(const MasterWatch&) = delete;

 private:
  void run();

  std::function<void()> lost_;
  std::function<void()> found_;
  std::function<void(const MasterState&)> look_;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace palpate::ros1

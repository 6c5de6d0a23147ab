/// \file
/// Monitoring of the ROS master. Includes no ROS headers, which do not compile as C++20.
#pragma once

#include <atomic>
#include <functional>
#include <thread>

namespace palpate::ros1 {

/// \throws std::runtime_error if ROS_MASTER_URI is not a valid URI; ROS itself would abort.
void require_master_uri();

/// Polls the master: whether it can be reached, and whether it is still the same process.
class MasterWatch {
 public:
  /// Starts polling. The callbacks run on its own thread. \param lost called once each time the master is
  /// lost \param found called when a master is reached again; `another` is true for a new process, which has
  /// no registrations \param reached called each time that the master answers, after `found` \pre ROS is
  /// initialised
  MasterWatch(
      std::function<void()> lost, std::function<void(bool another)> found,
      std::function<void()> reached = [] {});
  ~MasterWatch();
  MasterWatch(const MasterWatch&) = delete;
  MasterWatch& operator=(const MasterWatch&) = delete;

 private:
  void run();

  std::function<void()> lost_;
  std::function<void(bool)> found_;
  std::function<void()> reached_;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace palpate::ros1

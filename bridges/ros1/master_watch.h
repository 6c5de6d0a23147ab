/// \file
/// Whether there is a ROS master, without ROS headers: these do not compile as C++20.
#pragma once

#include <atomic>
#include <functional>
#include <thread>

namespace palpate::ros1 {

/// \throws std::runtime_error if ROS_MASTER_URI does not name one; ROS itself would abort.
void require_master_uri();

/// Asks the master now and then whether it is there, and whether it still is the same one.
class MasterWatch {
 public:
  /// Begins. Both are called by its own thread. \param lost once each time that it is gone \param found where
  /// there is one again; true: another process, which knows nobody \pre ROS is initialised
  MasterWatch(std::function<void()> lost, std::function<void(bool another)> found);
  ~MasterWatch();
  MasterWatch(const MasterWatch&) = delete;
  MasterWatch& operator=(const MasterWatch&) = delete;

 private:
  void run();

  std::function<void()> lost_;
  std::function<void(bool)> found_;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace palpate::ros1

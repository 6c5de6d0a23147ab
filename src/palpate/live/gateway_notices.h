/// \file
/// Notices that a gateway shows to its clients and on the terminal. Internal to live/.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace palpate {

/// Keeps notices: web pages show each until it changes, the terminal prints it once.
class GatewayNotices {
 public:
  /// Sets `notice` to `text`, and queues it for the terminal if it changed and is not empty. The gateway's
  /// thread.
  void tell(std::string& notice, const std::string& text) {
    if (notice == text) return;
    notice = text;
    change();
    if (text.empty()) return;
    const std::scoped_lock lock(mutex_);
    untold_.push_back(text);
  }
  /// Marks the notices on pages as changed. The gateway's thread.
  void change() { ++version_; }
  /// Returns a version number that every change increments. The gateway's thread.
  std::uint64_t version() const { return version_; }

  /// Returns the notices for the terminal since the last call. Any thread.
  std::vector<std::string> take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(untold_, {});
  }

 private:
  std::uint64_t version_ = 0;
  std::mutex mutex_;  ///< guards the members below
  std::vector<std::string> untold_;
};

}  // namespace palpate

/// \file
/// What a gateway has to tell people. Internal to live/.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace palpate {

/// Notices that hold until something else is to be said: for pages, and once for the terminal.
class GatewayNotices {
 public:
  /// `notice` becomes `text`, and is told if that is another and not empty. The gateway's thread.
  void tell(std::string& notice, const std::string& text) {
    if (notice == text) return;
    notice = text;
    change();
    if (text.empty()) return;
    const std::scoped_lock lock(mutex_);
    untold_.push_back(text);
  }
  /// What pages are told is another. The gateway's thread.
  void change() { ++version_; }
  /// Another number whenever that is so. The gateway's thread.
  std::uint64_t version() const { return version_; }

  /// For the terminal, since the last call. Any thread.
  std::vector<std::string> take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(untold_, {});
  }

 private:
  std::uint64_t version_ = 0;
  std::mutex mutex_;  ///< of what follows
  std::vector<std::string> untold_;
};

}  // namespace palpate

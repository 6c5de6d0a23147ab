/// \file
/// Messages of a node to its user, per hand.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>

#include <palpate/base/nonblocking_stderr.h>

namespace palpate::node {

/// Writes lines to the terminal, without waiting for it, and remembers the last one for diagnostics. Any
/// thread.
class NodeNotices {
 public:
  /// Notices of the node and its first hand. \param program name printed before each line
  explicit NodeNotices(std::string program) : speaker_(std::move(program)) {}
  /// Notices of another hand of that node.
  NodeNotices(const NodeNotices& node, const std::string& hand)
      : speaker_(node.speaker_ + ": hand " + hand) {}

  void say(const std::string& line) {
    write_to_stderr(speaker_ + ": " + line + "\n");
    const std::scoped_lock lock(mutex_);
    newest_ = line;
    ++count_;
  }

  struct Said {
    std::string newest;
    std::uint64_t count = 0;
  };
  Said said() const {
    const std::scoped_lock lock(mutex_);
    return {newest_, count_};
  }

 private:
  std::string speaker_;
  mutable std::mutex mutex_;
  std::string newest_;
  std::uint64_t count_ = 0;
};

}  // namespace palpate::node

/// \file
/// What a node has told a person.
#pragma once

#include <cstdint>
#include <cstdio>
#include <mutex>
#include <string>

namespace palpate::node {

/// Writes lines to the terminal, and remembers the last one for diagnostics. Any thread.
class NodeNotices {
 public:
  /// \param program that speaks
  explicit NodeNotices(std::string program) : program_(std::move(program)) {}

  void say(const std::string& line) {
    std::fprintf(stderr, "%s: %s\n", program_.c_str(), line.c_str());
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
  std::string program_;
  mutable std::mutex mutex_;
  std::string newest_;
  std::uint64_t count_ = 0;
};

}  // namespace palpate::node

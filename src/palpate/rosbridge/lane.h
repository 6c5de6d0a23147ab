/// \file
/// Threads of the web server. Internal to rosbridge/.
#pragma once

// GCC 12 needs <utility> before Asio.
#include <utility>

#include <new>
#include <optional>
#include <thread>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>

#include <palpate/base/real_time.h>

namespace palpate {

/// Runs `work`; a failed allocation abandons it, and the program, whose device may be in a user's hand,
/// continues.
template <class Work>
void do_if_there_is_memory(const Work& work) {
  try {
    work();
  } catch (const std::bad_alloc&) {
  }
}

/// A thread that runs posted work in order.
class Lane {
 public:
  boost::asio::io_context& context() { return context_; }

  void start(const char* name, const std::optional<ThreadPriority>& real_time = {}) {
    thread_ = std::thread([this, name, real_time] {
      name_thread(name);
      if (real_time) make_real_time(*real_time);  // the servo loop reports why it is not permitted
      // Work that runs out of memory is dropped, together with its connection.
      while (!context_.stopped()) do_if_there_is_memory([this] { context_.run(); });
    });
  }
  bool is_running() const { return thread_.joinable(); }
  /// Ends the thread once it has no pending work.
  void finish() {
    stays_.reset();
    thread_.join();
  }
  /// Ends the thread after the current work item; pending work is dropped.
  void stop() {
    context_.stop();
    thread_.join();
  }

 private:
  boost::asio::io_context context_{1};
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> stays_ =
      boost::asio::make_work_guard(context_);
  std::thread thread_;
};

}  // namespace palpate

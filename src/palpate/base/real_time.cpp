#include <palpate/base/real_time.h>

#include <cerrno>
#include <cstddef>
#include <future>
#include <system_error>

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <fmt/format.h>

namespace palpate {
namespace {

std::string reason(int error) { return std::generic_category().message(error); }

/// Stack size of threads started after memory is locked, stacks included: the default of 8 MiB would lock 24
/// MiB per hand, unused. Unit: [byte].
constexpr std::size_t kLockedStack = std::size_t{2} << 20;

void limit_stacks() {
  pthread_attr_t attributes;
  if (pthread_attr_init(&attributes) != 0) return;
  if (pthread_attr_setstacksize(&attributes, kLockedStack) == 0) pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

}  // namespace

std::optional<std::string> lock_memory() {
  limit_stacks();
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return std::nullopt;
  // An index larger than the memory: pages are then locked once they are touched.
  if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0) return std::nullopt;
  return fmt::format(
      "memory is not locked ({}): a page fault may delay a tick; raise 'ulimit -l', or give CAP_IPC_LOCK",
      reason(errno));
}

void name_thread(const char* name) { pthread_setname_np(pthread_self(), name); }

std::vector<std::string> make_real_time(const ThreadPriority& wanted) {
  std::vector<std::string> refused;
  sched_param priority{};
  priority.sched_priority = wanted.priority;
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority); error != 0) {
    refused.push_back(
        fmt::format("no real-time priority ({}): other programs may delay a tick; raise 'ulimit -r', or give "
                    "CAP_SYS_NICE",
                    reason(error)));
  }
  if (wanted.cpu) {
    cpu_set_t only;
    CPU_ZERO(&only);
    CPU_SET(static_cast<std::size_t>(*wanted.cpu), &only);
    if (const int error = pthread_setaffinity_np(pthread_self(), sizeof only, &only); error != 0) {
      refused.push_back(fmt::format("not pinned to processor {} ({}): choose an existing processor",
                                    *wanted.cpu, reason(error)));
    }
  }
  return refused;
}

void call_real_time(const ThreadPriority& wanted, const std::function<void()>& work) {
  std::async(std::launch::async, [&] {
    make_real_time(wanted);
    work();
  }).get();
}

}  // namespace palpate

/// \file
/// Real-time settings of a thread: memory locking and SCHED_FIFO priority.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace palpate {

/// Locks all current and future memory of the process, so that no tick waits for a page fault, and sets the
/// stack of threads started later to 2 MiB. \returns if locking is not permitted: a line that says why and
/// what to do.
std::optional<std::string> lock_memory();

/// Names the calling thread, as `top -H` shows it. \param name at most 15 characters
void name_thread(const char* name);

/// Requested scheduling of a thread.
struct ThreadPriority {
  int priority = 80;       ///< SCHED_FIFO priority, 1 to 99
  std::optional<int> cpu;  ///< processor to pin to; unset: any
};

/// Scheduling of the threads that read poses from a network: real-time, below the servo loops.
inline constexpr ThreadPriority kNetworkPriority{.priority = ThreadPriority{}.priority - 10, .cpu = {}};

/// Applies `wanted` to the calling thread. \returns a line for each setting that is not permitted; the thread
/// continues without it.
std::vector<std::string> make_real_time(const ThreadPriority& wanted);

/// Calls `work` on a temporary thread with the scheduling `wanted`, if permitted. The threads that `work`
/// starts inherit it: for those of a library that has no setting for it. Passes on what `work` throws.
void call_real_time(const ThreadPriority& wanted, const std::function<void()>& work);

}  // namespace palpate

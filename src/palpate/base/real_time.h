/// \file
/// Real-time settings of a thread: memory locking and SCHED_FIFO priority.
#pragma once

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

/// Applies `wanted` to the calling thread. \returns a line for each setting that is not permitted; the thread
/// continues without it.
std::vector<std::string> make_real_time(const ThreadPriority& wanted);

}  // namespace palpate

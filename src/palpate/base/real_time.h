/// \file
/// What an operating system can do for a thread that must not be late.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace palpate {

/// Locks all memory of the process, now and to come, so that no tick waits for a page; of which each thread
/// to come has 2 MiB as stack. \returns a line that says why not and what to do, where it is not allowed.
std::optional<std::string> lock_memory();

/// Gives the calling thread a name, as `top -H` shows it. \param name 15 characters at most
void name_thread(const char* name);

/// What is asked for a thread.
struct ThreadPriority {
  int priority = 80;       ///< of SCHED_FIFO, 1 to 99
  std::optional<int> cpu;  ///< to stay on; unset: any
};

/// Makes the calling thread one of real time. \returns a line for everything that is not allowed; the thread
/// goes on without it.
std::vector<std::string> make_real_time(const ThreadPriority& wanted);

}  // namespace palpate

/// \file
/// A loop on a fixed number of threads, so that results do not depend on the machine.
#pragma once

#include <cstddef>
#include <thread>
#include <vector>

namespace palpate::test {

inline constexpr std::size_t kThreads = 2;

/// Calls body(0) ... body(kThreads - 1), each on a thread of its own, and waits.
template <typename Body>
void on_threads(const Body& body) {
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < kThreads; ++i) threads.emplace_back([&body, i] { body(i); });
  for (std::thread& t : threads) t.join();
}

}  // namespace palpate::test

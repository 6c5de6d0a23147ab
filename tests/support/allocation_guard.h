/// \file
/// Counts what the calling thread takes from the heap, to show that a servo path takes nothing.
#pragma once

#include <cstddef>

namespace palpate::test {

/// How often the calling thread has called operator new so far.
std::size_t allocations_of_thread();

/// The next `count` calls of operator new by the calling thread throw std::bad_alloc.
void fail_allocations(std::size_t count);

/// Counts calls of operator new by the thread that made it, while it lives. Link
/// support/allocation_guard.cpp, which replaces operator new for the whole program.
class AllocationGuard {
 public:
  AllocationGuard();
  std::size_t count() const;

 private:
  std::size_t before_;
};

}  // namespace palpate::test

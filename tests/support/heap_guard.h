/// \file
/// Counts all that the calling thread takes from the heap, by malloc() too: Eigen does not call operator new.
#pragma once

#include <cstddef>

namespace palpate::test {

/// Counts calls of malloc() by the thread that made it, while it lives; operator new calls that. Link
/// support/heap_guard.cpp, which replaces malloc() for the whole program; under a sanitizer, which has its
/// own, nothing is counted.
class HeapGuard {
 public:
  HeapGuard();
  std::size_t count() const;

 private:
  std::size_t before_;
};

}  // namespace palpate::test

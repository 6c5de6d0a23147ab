#include <support/heap_guard.h>

namespace {

thread_local std::size_t calls = 0;

}  // namespace

#ifndef PALPATE_UNDER_SANITIZER
extern "C" void* __libc_malloc(std::size_t bytes);
extern "C" void* malloc(std::size_t bytes) {
  ++calls;
  return __libc_malloc(bytes);
}
#endif

namespace palpate::test {

HeapGuard::HeapGuard() : before_(calls) {}
std::size_t HeapGuard::count() const { return calls - before_; }

}  // namespace palpate::test

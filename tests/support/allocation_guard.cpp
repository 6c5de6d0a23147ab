#include <support/allocation_guard.h>

#include <cstdlib>
#include <new>

namespace {

thread_local std::size_t allocations = 0, failures = 0;

void* counted(std::size_t bytes, std::size_t alignment) {
  ++allocations;
  if (failures > 0) {
    --failures;
    throw std::bad_alloc();
  }
  const std::size_t size = (bytes + alignment - 1) / alignment * alignment;
  if (void* memory = std::aligned_alloc(alignment, size > 0 ? size : alignment)) return memory;
  throw std::bad_alloc();
}

}  // namespace

// The array and nothrow forms of the standard library call these; those of AddressSanitizer do not, and what
// its nothrow form returns would be freed by std::free().
void* operator new(std::size_t bytes) { return counted(bytes, alignof(std::max_align_t)); }
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  try {
    return operator new(bytes);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return counted(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace palpate::test {

std::size_t allocations_of_thread() { return allocations; }
void fail_allocations(std::size_t count) { failures = count; }

AllocationGuard::AllocationGuard() : before_(allocations) {}
std::size_t AllocationGuard::count() const { return allocations - before_; }

}  // namespace palpate::test

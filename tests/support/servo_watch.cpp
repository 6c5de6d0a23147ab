// A library for LD_PRELOAD that watches the servo thread of a running program: what it takes from the heap or
// gives back, which locks it takes, and what it writes, from one sleep of the loop to the next. At the end it
// writes
//   ticks heap locks writes heap_of_others
// to the file that SERVO_WATCH names. The last figure shows that it sees the heap at all.
#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <dlfcn.h>
#include <pthread.h>
#include <sys/uio.h>
#include <unistd.h>

namespace {

enum What { kTicks, kHeap, kLocks, kWrites, kOthersHeap, kFigures };

std::array<std::atomic<unsigned long>, kFigures> totals;

/// Of this thread. In the static block of thread-local memory: reaching it must not allocate.
struct Thread {
  bool watched = false;
  std::array<unsigned long, kFigures> since_sleep{};
};
__attribute__((tls_model("initial-exec"))) thread_local Thread self;

void count(What what) {
  if (self.watched) {
    ++self.since_sleep[what];
  } else if (what == kHeap) {
    totals[kOthersHeap].fetch_add(1, std::memory_order_relaxed);
  }
}

template <class Function>
Function next(const char* name) {
  Function function = nullptr;
  void* const symbol = dlsym(RTLD_NEXT, name);
  std::memcpy(&function, &symbol, sizeof function);
  return function;
}

struct AtExit {
  ~AtExit() {
    const char* path = std::getenv("SERVO_WATCH");
    std::FILE* file = path != nullptr ? std::fopen(path, "w") : nullptr;
    if (file == nullptr) return;
    for (const auto& total : totals) std::fprintf(file, "%lu ", total.load());
    std::fclose(file);
  }
} at_exit;

}  // namespace

extern "C" {

// Of glibc: what its own malloc() and so on call.
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) {
  count(kHeap);
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  count(kHeap);
  return __libc_calloc(n, size);
}
void* realloc(void* memory, std::size_t size) {
  count(kHeap);
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count(kHeap);
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  count(kHeap);
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? 12 : 0;  // ENOMEM
}
void free(void* memory) {
  if (memory != nullptr) count(kHeap);
  __libc_free(memory);
}

int pthread_mutex_lock(pthread_mutex_t* mutex) {
  static const auto real = next<int (*)(pthread_mutex_t*)>("pthread_mutex_lock");
  count(kLocks);
  return real(mutex);
}

ssize_t write(int file, const void* bytes, std::size_t size) {
  static const auto real = next<ssize_t (*)(int, const void*, std::size_t)>("write");
  count(kWrites);
  return real(file, bytes, size);
}
ssize_t writev(int file, const iovec* parts, int n) {
  static const auto real = next<ssize_t (*)(int, const iovec*, int)>("writev");
  count(kWrites);
  return real(file, parts, n);
}

int pthread_setname_np(pthread_t thread, const char* name) {
  static const auto real = next<int (*)(pthread_t, const char*)>("pthread_setname_np");
  const int result = real(thread, name);
  self.watched = std::strcmp(name, "palpate-servo") == 0;
  return result;
}

int clock_nanosleep(clockid_t clock, int flags, const timespec* until, timespec* left) {
  static const auto real = next<int (*)(clockid_t, int, const timespec*, timespec*)>("clock_nanosleep");
  if (self.watched) {
    // What the thread did before its first sleep, and does after its last, is not a tick's.
    static thread_local bool began = false;
    for (int i = 0; i < kFigures; ++i) {
      if (began) totals[static_cast<std::size_t>(i)].fetch_add(self.since_sleep[static_cast<std::size_t>(i)]);
    }
    self.since_sleep = {};
    self.since_sleep[kTicks] = 1;
    began = true;
  }
  return real(clock, flags, until, left);
}

}  // extern "C"

// Preloaded: the wall clock is an hour back from when the file $CLOCK_BACK exists.
#include <cstdlib>
#include <ctime>

#include <dlfcn.h>
#include <unistd.h>

extern "C" __attribute__((visibility("default"))) int clock_gettime(clockid_t clock, timespec* now) noexcept {
  static const auto read = reinterpret_cast<int (*)(clockid_t, timespec*)>(dlsym(RTLD_NEXT, "clock_gettime"));
  static const char* const file = std::getenv("CLOCK_BACK");  // NOLINT(concurrency-mt-unsafe)
  constexpr time_t kBack = 3600;
  const int error = read(clock, now);
  if (clock == CLOCK_REALTIME && file != nullptr && ::access(file, F_OK) == 0) now->tv_sec -= kBack;
  return error;
}

// A library for LD_PRELOAD: a disk that takes nothing for ten seconds, once.
#include <atomic>

#include <dlfcn.h>
#include <sys/stat.h>
#include <unistd.h>

extern "C" ssize_t write(int descriptor, const void* bytes, size_t size) {
  static const auto go_on = reinterpret_cast<decltype(&write)>(dlsym(RTLD_NEXT, "write"));
  static std::atomic<int> writes = 0;
  constexpr size_t kRows = 4096;  // more than anything but rows of a recording has
  struct stat about {};
  if (size >= kRows && ::fstat(descriptor, &about) == 0 && S_ISREG(about.st_mode) && ++writes == 2)
    ::sleep(10);
  return go_on(descriptor, bytes, size);
}

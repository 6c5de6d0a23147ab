// A library for LD_PRELOAD: a disk on which it takes three seconds until something is there for good.
#include <unistd.h>

extern "C" int fsync(int descriptor) {
  constexpr unsigned kSeconds = 3;
  ::sleep(kSeconds);
  return ::fdatasync(descriptor);
}

#include <palpate/rosbridge/wake.h>

#include <cerrno>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <system_error>

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <palpate/base/error.h>

namespace palpate {

Wake::Wake() : descriptor_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (descriptor_ < 0) throw Error("cannot make an eventfd: {}", std::generic_category().message(errno));
}

Wake::~Wake() { ::close(descriptor_); }

void Wake::set() {
  const std::uint64_t one = 1;
  // Fails only at the maximum count, 2^64 - 2: the event is then set already.
  [[maybe_unused]] const auto written = ::write(descriptor_, &one, sizeof one);
}

void Wake::wait(double seconds) {
  pollfd watched{descriptor_, POLLIN, 0};
  timespec limit{};
  if (seconds > 0.0) {
    limit.tv_sec = static_cast<std::time_t>(seconds);
    limit.tv_nsec = static_cast<long>((seconds - std::floor(seconds)) * 1e9);
  }
  if (::ppoll(&watched, 1, &limit, nullptr) > 0) clear();
}

void Wake::clear() {
  std::uint64_t count = 0;
  [[maybe_unused]] const auto read = ::read(descriptor_, &count, sizeof count);
}

}  // namespace palpate

#include <palpate/servo/guarded_device.h>

#include <algorithm>
#include <exception>

namespace palpate {
namespace {

constexpr std::string_view kUnknown = "its driver failed";

}  // namespace

/// \returns false if the driver throws or has thrown.
template <class Call>
bool GuardedDevice::guard(const Call& call) {
  if (!thrown().empty()) return false;
  std::string_view why = kUnknown;
  const auto keep = [&] {
    const std::size_t length = why.copy(text_.data(), text_.size());
    device_.stop();
    length_.store(length, std::memory_order_release);
  };
  try {
    return call();
  } catch (const std::exception& error) {
    if (*error.what() != '\0') why = error.what();
    keep();
  } catch (...) {
    keep();
  }
  return false;
}

bool GuardedDevice::read(double t, DeviceReading& reading) {
  return guard([&] { return device_.read(t, reading); });
}

void GuardedDevice::wait(const LoopClock& clock, double until) {
  const bool waited = guard([&] {
    device_.wait(clock, until);
    return true;
  });
  if (!waited) clock.sleep_until(until);  // the schedule continues, and with it the ramp-down of the force
}

void GuardedDevice::write(const Wrench& wrench) {
  guard([&] {
    device_.write(wrench);
    return true;
  });
}

}  // namespace palpate

#include <palpate/servo/guarded_device.h>

#include <algorithm>
#include <cstdint>
#include <exception>

#include <unistd.h>

namespace palpate {
namespace {

constexpr std::string_view kUnknown = "its driver failed";

/// Where the loop's thread is.
enum class Where : std::uint8_t { kOutside, kInside, kAbandoned };

}  // namespace

/// What a call of the driver uses.
struct GuardedDevice::Call {
  std::atomic<Where> where = Where::kOutside;
  std::atomic<bool> stopped = false;  ///< since the last write
  DeviceReading reading;
  Wrench wrench;
  LoopClock clock;

  void enter() { where.store(Where::kInside, std::memory_order_release); }
  /// Does not return if the call was abandoned. The driver may have written a wrench just now, after it was
  /// told to stop.
  void leave(HapticDevice& device) {
    Where inside = Where::kInside;
    if (where.compare_exchange_strong(inside, Where::kOutside, std::memory_order_acq_rel)) return;
    device.stop();
    for (;;) ::pause();
  }
};

GuardedDevice::GuardedDevice(HapticDevice& device)
    : device_(device), owned_(std::make_unique<Call>()), call_(*owned_) {}
GuardedDevice::~GuardedDevice() = default;

bool GuardedDevice::abandon() noexcept {
  Where inside = Where::kInside;
  if (!call_.where.compare_exchange_strong(inside, Where::kAbandoned, std::memory_order_acq_rel))
    return false;
  static_cast<void>(owned_.release());  // used if the driver ever returns
  return true;
}

/// \param work calls the driver, and uses nothing of this object but its parameters \returns false if the
/// driver throws or has thrown.
template <class Work>
bool GuardedDevice::guard(const Work& work) {
  if (!thrown().empty()) return false;
  Call& call = call_;
  HapticDevice& device = device_;  // read before the call, at which this object may be destroyed
  std::string_view why = kUnknown;
  const auto keep = [&] {
    const std::size_t length = why.copy(text_.data(), text_.size());
    device_.stop();
    length_.store(length, std::memory_order_release);
  };
  call.enter();
  try {
    const bool done = work(device, call);
    call.leave(device);
    return done;
  } catch (const std::exception& error) {
    call.leave(device);
    if (*error.what() != '\0') why = error.what();
    keep();
  } catch (...) {
    call.leave(device);
    keep();
  }
  return false;
}

bool GuardedDevice::read(double t, DeviceReading& reading) {
  call_.reading = reading;
  if (!guard([t](HapticDevice& device, Call& call) { return device.read(t, call.reading); })) return false;
  reading = call_.reading;
  return true;
}

void GuardedDevice::wait(const LoopClock& clock, double until) {
  call_.clock = clock;
  const bool waited = guard([until](HapticDevice& device, Call& call) {
    device.wait(call.clock, until);
    return true;
  });
  if (!waited) clock.sleep_until(until);  // the schedule continues, and with it the ramp-down of the force
}

void GuardedDevice::write(const Wrench& wrench) {
  call_.wrench = wrench;
  guard([](HapticDevice& device, Call& call) {
    device.write(call.stopped.exchange(false) ? Wrench{} : call.wrench);
    return true;
  });
}

void GuardedDevice::stop() noexcept {
  call_.stopped.store(true);
  device_.stop();
}

bool GuardedDevice::come_to_rest() {
  const bool rests = guard([](HapticDevice& device, Call&) { return device.come_to_rest(); });
  return rests || !thrown().empty();  // one that has thrown was told to stop
}

}  // namespace palpate

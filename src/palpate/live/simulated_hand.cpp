#include <palpate/live/simulated_hand.h>

#include <optional>
#include <utility>

#include <palpate/device/hand_path.h>
#include <palpate/device/led_hand.h>

namespace palpate {
namespace {

constexpr double kTremor = 2e-5;  ///< Unit: [m].

}  // namespace

HandPath simulated_hand(HandPath own, ClientHand& client, std::atomic<bool>& moves_itself) {
  HandPath halting = [own = std::move(own), &moves_itself, moved = 0.0, before = 0.0](double t) mutable {
    if (moves_itself.load(std::memory_order_relaxed)) moved += t - before;
    before = t;
    return own(moved);
  };
  const LedHand::Lead lead = [&client, &moves_itself, left = std::optional<Pose>()](double) mutable {
    const ClientHand::Sample& newest = client.newest();
    if (client.is_held()) {
      left = newest.pose.in_device_frame();
      moves_itself.store(false, std::memory_order_relaxed);
    } else if (moves_itself.load(std::memory_order_relaxed)) {
      left.reset();
    }
    return left;
  };
  return with_tremor(LedHand(std::move(halting), lead), kTremor);
}

}  // namespace palpate

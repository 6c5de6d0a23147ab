/// \file
/// The newest tick, for the gateway's thread.
#pragma once

#include <palpate/base/triple_buffer.h>
#include <palpate/gateway/client_hand.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// Hands every tick over, and wakes the gateway where a client holds the hand: it gets the force of every
/// tick, that of the fall to zero, too, when it has fallen silent.
class TickFeed final : public TickObserver {
 public:
  struct Tick {
    TickRecord record;
    TickTimes times;
    std::uint64_t answers = 0;  ///< ClientHand::Sample::number of the pose that the hand was at
  };

  /// `hand` must outlive it.
  explicit TickFeed(const ClientHand& hand) : hand_(hand) {}

  /// The servo thread.
  void see(const TickRecord& record, const TickTimes& times) override {
    const std::uint64_t answers = hand_.seen();
    ticks_.back() = {record, times, answers};
    ticks_.publish();
    if (hand_.is_held()) wake_.set();
  }

  /// \name One other thread
  /// @{
  /// True if there was a tick since the last call; newest() is then that of it.
  bool update() { return ticks_.update(); }
  const Tick& newest() const { return ticks_.front(); }
  Wake& wake() { return wake_; }
  /// @}

 private:
  const ClientHand& hand_;
  TripleBuffer<Tick> ticks_;
  Wake wake_;
};

}  // namespace palpate

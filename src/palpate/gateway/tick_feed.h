/// \file
/// Transfer of the newest tick from the servo thread to the gateway thread.
#pragma once

#include <palpate/base/triple_buffer.h>
#include <palpate/gateway/client_hand.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// Passes every tick to the gateway thread, and wakes it while a client holds the hand: the client gets the
/// force of every tick, including the ramp to zero after it has fallen silent.
class TickFeed final : public TickObserver {
 public:
  struct Tick {
    TickRecord record;
    TickTimes times;
    std::uint64_t answers = 0;  ///< ClientHand::Sample::number of the pose that the tick used
  };

  /// `hand` must outlive it.
  explicit TickFeed(const ClientHand& hand) : hand_(hand) {}

  /// The servo thread.
  void see(const TickRecord& record, const TickTimes& times) override {
    stall_.clear();
    const std::uint64_t answers = hand_.seen();
    ticks_.back() = {record, times, answers};
    ticks_.publish();
    if (hand_.is_held()) wake_.set();
  }
  void stall() override {
    stall_.set();
    if (hand_.is_held()) wake_.set();
  }

  /// \name One other thread
  /// @{
  /// Returns whether there was a tick since the last call, or the loop has stalled, and moves newest() to it.
  bool update() {
    const bool ticked = ticks_.update();
    return stall_.apply(ticks_.front().record) || ticked;
  }
  const Tick& newest() const { return ticks_.front(); }
  Wake& wake() { return wake_; }
  /// @}

 private:
  const ClientHand& hand_;
  TripleBuffer<Tick> ticks_;
  StallFlag stall_;
  Wake wake_;
};

}  // namespace palpate

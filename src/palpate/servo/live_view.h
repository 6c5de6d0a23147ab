/// \file
/// What a loop is doing, for who looks on.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>

#include <palpate/base/triple_buffer.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// What a loop has felt so far.
struct LiveTotals {
  std::uint64_t contact_ticks = 0;  ///< in which the tool touched something
  std::uint64_t contacts_max = 0;
  double force_max = 0.0;    ///< that was sent. Unit: [N].
  double port_energy = 0.0;  ///< PassivityController::put_out(). Unit: [J].
  double margin_min = 0.0;   ///< the least of TickRecord::margin; 0 if there was none
};

/// Keeps the newest tick, what has come together, and every change of the governor's state. The servo thread
/// calls see(); the rest is for one other thread, unless it says more.
class LiveView final : public TickObserver {
 public:
  void see(const TickRecord& record, const TickTimes& times) override;

  /// True if there was a tick since the last call; newest() is then that of it.
  bool update() { return newest_.update(); }
  const TickRecord& newest() const { return newest_.front().record; }
  const TickTimes& times() const { return newest_.front().times; }
  LiveTotals totals() const { return newest_.front().totals; }

  /// The changes of state, oldest first; of more than kRemembered the first. Any thread.
  std::span<const GovernorTransition> transitions() const {
    return {transitions_.data(), remembered_.load(std::memory_order_acquire)};
  }
  static constexpr std::size_t kRemembered = 4096;

 private:
  struct Snapshot {
    TickRecord record;
    TickTimes times;
    LiveTotals totals;
  };

  void add(const TickRecord& record);

  TripleBuffer<Snapshot> newest_;
  std::array<GovernorTransition, kRemembered> transitions_;
  std::atomic<std::size_t> remembered_ = 0;
  // Of the servo thread.
  LiveTotals totals_;
  GovernorState state_ = GovernorState::kWaiting;
  Fault fault_ = Fault::kNone;
};

}  // namespace palpate

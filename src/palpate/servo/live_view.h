/// \file
/// Live view of a running servo loop for another thread.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>

#include <palpate/base/triple_buffer.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// Totals of a loop since its start.
struct LiveTotals {
  std::uint64_t contact_ticks = 0;  ///< ticks with contact
  std::uint64_t contacts_max = 0;
  double force_max = 0.0;                         ///< largest force sent. Unit: [N].
  double port_energy = 0.0;                       ///< PassivityController::port_energy(). Unit: [J].
  double margin_min = 0.0;                        ///< the least of TickRecord::margin; 0 if there was none
  GovernorState state = GovernorState::kWaiting;  ///< as of the last tick before the end (Fault::kEnded)
};

/// Keeps the newest tick, running totals, and every state transition of the governor until the end is
/// requested (Fault::kEnded). The servo thread calls see(); all other functions are for one other thread
/// unless stated otherwise.
class LiveView final : public TickObserver {
 public:
  void see(const TickRecord& record, const TickTimes& times) override;
  void stall() override { stall_.set(); }

  /// Returns true if there was a tick since the last call, or the loop has stalled; newest() then says so.
  bool update();
  const TickRecord& newest() const { return newest_.front().record; }
  const TickTimes& times() const { return newest_.front().times; }
  LiveTotals totals() const { return newest_.front().totals; }
  /// Returns whether the loop has stalled since its last tick, which is in no transition yet. Any thread.
  bool has_stalled() const { return stall_.is_set(); }

  /// State transitions, oldest first; only the first kRemembered are kept. Any thread.
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
  void remember(const TickRecord& record);

  TripleBuffer<Snapshot> newest_;
  StallFlag stall_;
  std::array<GovernorTransition, kRemembered> transitions_;
  std::atomic<std::size_t> remembered_ = 0;
  // Of the servo thread.
  LiveTotals totals_;
  Fault fault_ = Fault::kNone;
  bool ends_ = false;
};

}  // namespace palpate

/// \file
/// Wait-free single-producer single-consumer ring buffer.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace palpate {

/// Passes values from one producer to one consumer, in order, each once. No locks; only the constructor
/// allocates; both sides take a bounded number of steps per value.
///
///     slots      |   | c | d | e |   |      tail <= head <= tail + room
///                     tail        head      each only grows, and counts all values ever
///
/// The producer fills a slot and then releases `head`; the consumer acquires `head`, empties the slot and
/// then releases `tail`, which the producer acquires before it fills that slot again.
template <typename T>
class SpscRing {
 public:
  /// \param room minimum capacity; rounded up to a power of two. > 0
  explicit SpscRing(std::size_t room) : slots_(std::bit_ceil(room)) {}

  std::size_t room() const { return slots_.size(); }

  /// Called by the producer. \returns false, leaving the ring unchanged, if it is full.
  bool push(const T& value) {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == slots_.size()) return false;
    slots_[head & (slots_.size() - 1)] = value;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Called by the consumer: passes the values present now to `take`, oldest first.
  template <typename Take>
  void drain(Take&& take) {
    const std::uint64_t head = head_.load(std::memory_order_acquire);
    for (std::uint64_t tail = tail_.load(std::memory_order_relaxed); tail != head; ++tail) {
      take(slots_[tail & (slots_.size() - 1)]);
      tail_.store(tail + 1, std::memory_order_release);
    }
  }

 private:
  static constexpr std::size_t kCacheLine = 64;  // avoids false sharing

  std::vector<T> slots_;
  alignas(kCacheLine) std::atomic<std::uint64_t> head_ = 0;  ///< written by the producer
  alignas(kCacheLine) std::atomic<std::uint64_t> tail_ = 0;  ///< written by the consumer
};

}  // namespace palpate

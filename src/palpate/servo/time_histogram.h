/// \file
/// Histogram of durations with quantiles, updated in real time.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace palpate {

/// Counts durations in classes 2^(1/16) apart, 4 % each, from 10 ns to a minute. One thread adds; any thread
/// may read concurrently and may miss the latest entries.
class TimeHistogram {
 public:
  /// \param seconds counted in the first or last class if out of range
  void add(double seconds);

  std::uint64_t count() const { return count_.load(std::memory_order_relaxed); }
  /// The middle of the class that holds the q-quantile; 0 if there is none. max() for q = 1. Unit: [s].
  double quantile(double q) const;
  /// Unit: [s].
  double max() const { return max_.load(std::memory_order_relaxed); }

 private:
  friend class TimeWindow;
  static constexpr int kPerOctave = 16;
  static constexpr double kFirst = 1e-8;  ///< Unit: [s].
  static constexpr std::size_t kClasses = std::size_t{kPerOctave} * 33;

  /// The middle of a class. Unit: [s].
  static double middle(std::size_t k);

  std::array<std::atomic<std::uint64_t>, kClasses> classes_{};
  std::atomic<std::uint64_t> count_ = 0;
  std::atomic<double> max_ = 0.0;
};

/// Durations added to a TimeHistogram between two calls of next(). One thread, while another adds.
class TimeWindow {
 public:
  /// `of` must outlive it.
  explicit TimeWindow(const TimeHistogram& of) : of_(of) {}

  /// Starts a new evaluation, of the durations since the last call, or since the beginning.
  void next();
  std::uint64_t count() const { return count_; }
  /// Accurate to the width of a class; 0 if empty. Unit: [s].
  double mean() const;
  double quantile(double q) const;

 private:
  using Counts = std::array<std::uint64_t, TimeHistogram::kClasses>;

  const TimeHistogram& of_;
  Counts seen_{};    ///< since the beginning
  Counts counts_{};  ///< in the window
  std::uint64_t count_ = 0;
};

}  // namespace palpate

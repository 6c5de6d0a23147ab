/// \file
/// Measurement of time and memory.
#pragma once

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

#include <palpate/study/latency.h>

#include "pipeline.h"

namespace palpate::bench {

/// Resident set of this process, after the heap has returned its free memory to the system, so that the
/// growth is the memory of a structure, including memory that it maps itself. Unit: [bytes].
std::size_t resident_bytes();

/// Monitors the anonymous memory of this process from its own thread. Pages of mapped files, which the system
/// may reclaim at any time, are not included.
class AnonymousMemoryWatch {
 public:
  AnonymousMemoryWatch();
  ~AnonymousMemoryWatch();
  AnonymousMemoryWatch(const AnonymousMemoryWatch&) = delete;
  AnonymousMemoryWatch& operator=(const AnonymousMemoryWatch&) = delete;

  /// Largest value so far, sampled at 100 Hz. Unit: [bytes].
  std::size_t peak() const { return peak_; }

 private:
  void look();

  std::atomic<std::size_t> peak_{0};
  std::atomic<bool> done_{false};
  std::thread thread_;
};

/// Measures the time of every pose with every pipeline: the minimum over `rounds`, since other load only adds
/// time. In each round, the pipelines run all poses in turn, so that a slow minute affects all of them.
/// \returns times by pipeline and pose. Unit: [us].
std::vector<std::vector<double>> measure(const Pipelines& pipelines, const std::vector<Ellipsoid>& poses,
                                         int rounds);

}  // namespace palpate::bench

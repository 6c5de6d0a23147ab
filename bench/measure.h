/// \file
/// Time and memory.
#pragma once

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

#include <palpate/study/latency.h>

#include "pipeline.h"

namespace palpate::bench {

/// The resident set of this process, after the heap has returned to the system what is free in it: so that
/// its growth is what a structure holds, also where it maps memory on its own. Unit: [bytes].
std::size_t resident_bytes();

/// Watches the anonymous memory of this process (what it holds besides mapped files, whose pages the system
/// may have back at any time) from a thread of its own.
class AnonymousMemoryWatch {
 public:
  AnonymousMemoryWatch();
  ~AnonymousMemoryWatch();
  AnonymousMemoryWatch(const AnonymousMemoryWatch&) = delete;
  AnonymousMemoryWatch& operator=(const AnonymousMemoryWatch&) = delete;

  /// The most that was seen, looking a hundred times a second. Unit: [bytes].
  std::size_t peak() const { return peak_; }

 private:
  void look();

  std::atomic<std::size_t> peak_{0};
  std::atomic<bool> done_{false};
  std::thread thread_;
};

/// Of every pipeline, the time of every pose: the least of `rounds`, since whatever else the machine does
/// only adds. In each round every pipeline sees all poses in turn, so that a slow minute is nobody's own.
/// Unit: [us].
std::vector<std::vector<double>> measure(const Pipelines& pipelines, const std::vector<Ellipsoid>& poses,
                                         int rounds);

}  // namespace palpate::bench

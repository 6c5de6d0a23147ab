#include "measure.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <limits>
#include <string>

namespace palpate::bench {
namespace {

void run_round(Pipeline& pipeline, const std::vector<Ellipsoid>& poses, std::vector<double>& least) {
  pipeline.prepare();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Stopwatch watch;
    pipeline.query(poses[i]);
    least[i] = std::min(least[i], watch.microseconds());
  }
}

}  // namespace

std::size_t resident_bytes() {
  malloc_trim(0);
  std::size_t total = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

AnonymousMemoryWatch::AnonymousMemoryWatch() {
  look();
  thread_ = std::thread([this] {
    while (!done_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      look();
    }
  });
}

AnonymousMemoryWatch::~AnonymousMemoryWatch() {
  done_ = true;
  thread_.join();
}

void AnonymousMemoryWatch::look() {
  std::ifstream status("/proc/self/status");
  for (std::string field; status >> field;) {
    if (field != "RssAnon:") continue;
    std::size_t kib = 0;
    status >> kib;
    peak_ = std::max<std::size_t>(peak_, kib * 1024);
    return;
  }
}

std::vector<std::vector<double>> measure(const Pipelines& pipelines, const std::vector<Ellipsoid>& poses,
                                         int rounds) {
  const std::vector<double> never(poses.size(), std::numeric_limits<double>::infinity());
  std::vector<std::vector<double>> least(pipelines.size(), never);
  for (int round = 0; round < rounds; ++round)
    for (std::size_t p = 0; p < pipelines.size(); ++p) run_round(*pipelines[p], poses, least[p]);
  return least;
}

}  // namespace palpate::bench

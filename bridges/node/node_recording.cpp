#include "node_recording.h"

#include <chrono>
#include <filesystem>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/live/config_toml.h>
#include <palpate/live/provenance.h>

namespace palpate::node {
namespace {

/// Runs the work in the caller's thread, which may block: emergency stop and pause have another thread.
void at_once(const std::function<void()>& work, const std::function<void()>& then) {
  work();
  then();
}

}  // namespace

NodeRecording::NodeRecording(const std::string& folder, std::string hand, const LiveSystem& system,
                             const std::optional<RecorderOptions>& rows)
    : folder_(std::filesystem::absolute(folder).lexically_normal().string()),
      hand_(std::move(hand)),
      system_(system),
      switch_(at_once, {}, rows.value_or(recorder_options(system.device())), [this] { return next(); }) {}

/// Path of the next file, named as rosbag names its files: palpate-2026-11-26-17-34-05.csv, palpate-left-...
std::string NodeRecording::next() const {
  const std::string name =
      fmt::format("palpate-{}{:%Y-%m-%d-%H-%M-%S}", hand_.empty() ? "" : hand_ + "-",
                  fmt::localtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
  std::filesystem::path path = std::filesystem::path(folder_) / (name + ".csv");
  for (int k = 2; std::filesystem::exists(path); ++k)
    path.replace_filename(fmt::format("{}-{}.csv", name, k));
  return path.string();
}

std::string NodeRecording::set(bool on, const std::function<void()>& may_begin) {
  const std::scoped_lock lock(mutex_);
  std::string failure;
  if (on) {
    switch_.begin(
        [&] {
          may_begin();
          return to_toml(system_.provenance("run"));
        },
        [&failure](const std::string& why) { failure = why; });
    show();
  } else {
    failure = end();
  }
  if (!failure.empty()) throw Error("{}", failure);
  return switch_.path();
}

/// Ends the recording. \returns a message if it had failed before, which names the partial file.
std::string NodeRecording::end() {
  std::string said;
  switch_.end([&](const std::string& failure) {
    if (!failure.empty())
      said =
          fmt::format("the recording has ended: {}; the data up to then is in {}", failure, switch_.path());
    else if (switch_.lost() > 0)
      lacks_ =
          fmt::format("warning: the recording lacks {} ticks: the disk is too slow; the others are in {}",
                      switch_.lost(), switch_.path());
  });
  show();
  return said;
}

std::string NodeRecording::look() {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return {};
  return switch_.failure() ? end() : std::exchange(lacks_, {});
}

std::string NodeRecording::close() {
  const std::scoped_lock lock(mutex_);
  const std::string failure = switch_.is_on() ? end() : std::string();
  return failure.empty() ? std::exchange(lacks_, {}) : failure;
}

std::string NodeRecording::path() const {
  const std::scoped_lock lock(shown_mutex_);
  return shown_;
}

void NodeRecording::show() {
  std::string path = switch_.is_on() ? switch_.path() : std::string();
  const std::scoped_lock lock(shown_mutex_);
  shown_ = std::move(path);
}

}  // namespace palpate::node

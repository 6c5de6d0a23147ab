#include "live_recording.h"

#include <filesystem>

#include <fmt/format.h>
#include <unistd.h>

#include <palpate/base/clock.h>
#include <palpate/base/error.h>
#include <palpate/servo/run_log.h>

#include "markup.h"
#include "report.h"

namespace palpate::cli {

RecordingSwitch::~RecordingSwitch() {
  if (maker_.joinable()) maker_.join();
  recorder_.reset();
  if (!folder_.empty()) {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
}

void RecordingSwitch::see(const TickRecord& record, const TickTimes& times) {
  if (Recorder* const recorder = used_.load(std::memory_order_acquire))
    recorder->push(run_row(record, times));
  ticks_.fetch_add(1, std::memory_order_release);
}

void RecordingSwitch::begin() {
  if (recorder_) throw Error("a recording is under way");
  if (folder_.empty()) {
    std::string pattern = (std::filesystem::temp_directory_path() / "palpate-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr)
      throw Error("cannot make a folder for recordings in {}", pattern);
    folder_ = pattern;
  }
  path_ = fmt::format("{}/recording-{}.csv", folder_, ++count_);
  recorder_ = std::make_unique<Recorder>(path_);
  used_.store(recorder_.get(), std::memory_order_release);
}

void RecordingSwitch::end() {
  if (!recorder_) throw Error("nothing is being recorded");
  used_.store(nullptr, std::memory_order_release);
  // A tick that is under way may still use it; one that begins now does not. If none ends in time, because
  // the loop stands still, nobody knows, and it is kept.
  constexpr double kPatience = 0.1, kLook = 1e-3;  // s
  const std::uint64_t seen = ticks_.load(std::memory_order_acquire);
  const double until = monotonic_now() + kPatience;
  while (ticks_.load(std::memory_order_acquire) == seen && monotonic_now() < until)
    sleep_until(monotonic_now() + kLook);
  recorder_->close();
  const std::optional<std::string> failure = recorder_->failure();
  if (ticks_.load(std::memory_order_acquire) == seen) retired_.push_back(std::move(recorder_));
  recorder_.reset();
  if (failure) throw Error("{}", *failure);
  if (maker_.joinable()) maker_.join();
  maker_ = std::thread([this, path = path_] { make_page(path); });
}

void RecordingSwitch::make_page(const std::string& path) {
  std::string page;
  try {
    auto csv = std::make_shared<const MappedFile>(path);
    {
      const std::scoped_lock lock(mutex_);
      csv_ = std::move(csv);
      page_.reset();
    }
    version_.fetch_add(1, std::memory_order_release);
    page = report_document(read_run(path), std::filesystem::path(path).filename().string());
  } catch (const Error& error) {
    page = "<!doctype html><title>no report</title><p>" + markup_escaped(error.what());
  }
  {
    const std::scoped_lock lock(mutex_);
    page_ = std::make_shared<const std::string>(std::move(page));
  }
  version_.fetch_add(1, std::memory_order_release);
}

std::shared_ptr<const MappedFile> RecordingSwitch::csv() const {
  const std::scoped_lock lock(mutex_);
  return csv_;
}

std::shared_ptr<const std::string> RecordingSwitch::page() const {
  const std::scoped_lock lock(mutex_);
  return page_;
}

}  // namespace palpate::cli

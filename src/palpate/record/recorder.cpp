#include <palpate/record/recorder.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>

#include <palpate/base/error.h>

namespace palpate {
namespace {

constexpr std::size_t kTextBytes = std::size_t{1} << 16;  // size of a write to the file
constexpr std::size_t kLineBytes = 2048;                  // upper bound of a line

/// Returns the row with 0 in place of values that are not finite. \param columns of the recording
RunRow finite(const RunRow& row, const std::vector<RunColumn>& columns) {
  RunRow made = row;
  for (const RunColumn& column : columns) {
    if (!std::isfinite(column.get(made))) column.set(made, 0.0);
  }
  return made;
}

}  // namespace

RecorderOptions recorder_options(const DeviceCapabilities& device) {
  RecorderOptions options;
  options.user_force = device.kind == Causality::kAdmittance;
  return options;
}

Recorder::Recorder(const std::string& path, const RecorderOptions& options)
    : columns_(run_columns({.user_force = options.user_force, .live = true})),
      file_(path, csv_comment(options.made) + run_header(columns_)),
      ring_(options.room) {
  text_.reserve(kTextBytes + kLineBytes);
  writer_ = std::thread([this] { write_until_closed(); });
}

Recorder::~Recorder() { close(); }

bool Recorder::push(const RunRow& row) noexcept {
  const bool follows = row.t > last_t_ && row.t <= std::numeric_limits<double>::max();  // false for NaN
  if (!follows || !accepts_.load(std::memory_order_relaxed) || !ring_.push(row)) {
    refused_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  last_t_ = row.t;
  return true;
}

void Recorder::close() {
  if (!writer_.joinable()) return;
  accepts_.store(false, std::memory_order_relaxed);
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  closing_.notify_one();
  writer_.join();
}

std::optional<std::string> Recorder::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

void Recorder::write_until_closed() {
  // Other threads handle signals. SIGXFSZ, at the file size limit, would terminate the process before write()
  // fails.
  sigset_t all;
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_BLOCK, &all, nullptr);

  for (bool closed = false; !closed;) {
    {
      std::unique_lock lock(mutex_);
      closed = closing_.wait_for(lock, std::chrono::duration<double>(kInterval), [this] { return closed_; });
    }
    write_all();
  }
  try {
    file_.finish();
  } catch (const Error& error) {
    fail(error.what());
  }
}

void Recorder::write_all() {
  ring_.drain([this](const RunRow& row) {
    if (failed_) {
      unwritten_.fetch_add(1, std::memory_order_relaxed);
    } else {
      append(row);
    }
  });
  flush();
}

void Recorder::append(const RunRow& row) {
  append_run_row(text_, finite(row, columns_), columns_);
  if (text_.size() >= kTextBytes) flush();
}

void Recorder::flush() {
  const std::uint64_t before = file_.size();
  try {
    file_.append(text_);
  } catch (const Error& error) {
    fail(error.what());
  }
  const auto end_of_written = text_.begin() + static_cast<std::ptrdiff_t>(file_.size() - before);
  const auto rows = [](auto first, auto last) {
    return static_cast<std::uint64_t>(std::count(first, last, '\n'));
  };
  written_.fetch_add(rows(text_.begin(), end_of_written), std::memory_order_relaxed);
  unwritten_.fetch_add(rows(end_of_written, text_.end()), std::memory_order_relaxed);
  text_.clear();
}

/// Keeps the first reason, which is the one to report.
void Recorder::fail(const std::string& why) {
  failed_ = true;
  accepts_.store(false, std::memory_order_relaxed);
  const std::lock_guard lock(mutex_);
  if (!failure_) failure_ = why;
}

}  // namespace palpate

#include <palpate/live/recording_switch.h>

#include <exception>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/clock.h>
#include <palpate/base/error.h>

namespace palpate {

RecordingSwitch::~RecordingSwitch() {
  if (maker_.joinable()) maker_.join();
  job_.reset();  // before the folder
}

void RecordingSwitch::see(const TickRecord& record, const TickTimes& times) {
  if (Recorder* const recorder = used_.load(std::memory_order_acquire))
    recorder->push(run_row(record, times));
  ticks_.fetch_add(1, std::memory_order_release);
}

void RecordingSwitch::begin(std::function<std::string()> made, Done done) {
  if (state_ != State::kOff)
    throw Error("a recording is {}", state_ == State::kEnding ? "being ended" : "under way");
  set(State::kBeginning);
  job_ = std::make_shared<Job>();
  job_->made = std::move(made);
  elsewhere_([this, job = job_] { make(*job); },
             [this, job = job_, done = std::move(done)] {
               set(job->failure.empty() ? State::kOn : State::kOff);
               used_.store(job->recorder.get(), std::memory_order_release);
               done(job->failure);
               if (!ends_) return;
               const Done ended = *std::exchange(ends_, std::nullopt);
               is_on() ? end_now(ended) : ended(job->failure);
             });
}

void RecordingSwitch::set(State state) {
  state_ = state;
  under_way_.store(state != State::kOff, std::memory_order_release);
}

/// Called on the Elsewhere thread.
std::string RecordingSwitch::next_in_own_folder() {
  if (!folder_) folder_.emplace("palpate");
  return folder_->path() / fmt::format("recording-{}.csv", ++count_);
}

/// Called on the Elsewhere thread: the recorder's thread inherits its normal priority.
void RecordingSwitch::make(Job& job) {
  try {
    job.path = place_ ? place_() : next_in_own_folder();
    RecorderOptions options = rows_;
    options.made = job.made();
    job.recorder = std::make_unique<Recorder>(job.path, options);
  } catch (const Error& error) {
    job.failure = error.what();
  } catch (const std::exception& error) {  // no temporary folder, thread or memory
    job.failure = fmt::format("cannot record: {}", error.what());
  }
}

std::optional<std::string> RecordingSwitch::failure() const {
  return is_on() ? job_->recorder->failure() : std::nullopt;
}

void RecordingSwitch::end(Done done) {
  if (is_on()) return end_now(std::move(done));
  if (state_ != State::kBeginning || ends_) throw Error("nothing is being recorded");
  ends_ = std::move(done);
}

void RecordingSwitch::end_now(Done done) {
  set(State::kEnding);
  used_.store(nullptr, std::memory_order_release);
  elsewhere_([this, job = job_] { finish(*job); },
             [this, job = job_, done = std::move(done)] {
               set(State::kOff);
               done(job->failure);
             });
}

/// Called on the Elsewhere thread.
void RecordingSwitch::finish(Job& job) {
  // A tick in progress may still use the recorder; one that begins now does not. If no tick ends in time, as
  // in a loop that hangs, the recorder may be in use and is kept.
  constexpr double kLongest = 0.1, kLook = 1e-3;  // s
  const std::uint64_t seen = ticks_.load(std::memory_order_acquire);
  const double until = monotonic_now() + kLongest;
  while (ticks_.load(std::memory_order_acquire) == seen && monotonic_now() < until)
    sleep_until(monotonic_now() + kLook);
  job.recorder->close();
  job.failure = job.recorder->failure().value_or("");
  job.lost = job.recorder->lost();
  if (ticks_.load(std::memory_order_acquire) == seen) retired_.push_back(std::move(job.recorder));
  job.recorder.reset();
  if (maker_.joinable()) maker_.join();
  try {
    set({std::make_shared<const InputFile>(job.path), nullptr});
    if (!page_) return;
    maker_ = std::thread([this, path = job.path] {
      set({recorded().csv, std::make_shared<const std::string>(page_(path))});
    });
  } catch (const std::exception& error) {
    if (job.failure.empty()) job.failure = error.what();
  }
}

void RecordingSwitch::set(Recorded recorded) {
  const std::scoped_lock lock(mutex_);
  recorded.version = recorded_.version + 1;
  std::swap(recorded_, recorded);
}

RecordingSwitch::Recorded RecordingSwitch::recorded() const {
  const std::scoped_lock lock(mutex_);
  return recorded_;
}

}  // namespace palpate

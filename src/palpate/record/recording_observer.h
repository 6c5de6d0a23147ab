/// \file
/// Observer that records every tick of a live loop.
#pragma once

#include <palpate/record/recorder.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// Pushes a row per tick into a Recorder, which must outlive the observed loop.
class RecordingObserver final : public TickObserver {
 public:
  explicit RecordingObserver(Recorder& recorder) : recorder_(recorder) {}
  /// Servo thread.
  void see(const TickRecord& record, const TickTimes& times) override {
    recorder_.push(run_row(record, times));
  }

 private:
  Recorder& recorder_;
};

}  // namespace palpate

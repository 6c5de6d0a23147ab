#include <palpate/gateway/stamp_clock.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpate {

/// Lets the estimate rise by what the clocks may have drifted apart since the last message.
void StampClock::drift(double now) {
  const double passed = now - std::exchange(heard_, now);
  if (zero_ && !late_) *zero_ += kDrift * passed;
}

/// \param least age of a message with the shortest delay. Unit: [s].
StampClock::Check StampClock::judge(double stamp, double now, double least) {
  const double offset = now - stamp;
  if (offset - *zero_ < least - kFuture) return {Verdict::kFuture};
  zero_ = std::min(*zero_, offset - least);
  const double age = offset - *zero_;
  const bool in_order = stamp > newest_ || now - used_ >= kSettle;
  if (age > age_limit_ || !in_order) return {Verdict::kLate, age};
  newest_ = stamp;
  used_ = now;
  return {Verdict::kUsable, age};
}

/// Takes a message that is not usable. \returns whether it shows that the clock was set.
bool StampClock::was_set(double stamp, double now, Verdict verdict) {
  const double offset = now - stamp;
  const bool unexplained = verdict == Verdict::kFuture || stamp < newest_;
  const bool continues =
      other_ && stamp > other_->newest && now - other_->heard < kSettle && offset > other_->least - kFuture;
  if (continues) {
    other_->least = std::min(other_->least, offset);
    other_->newest = stamp;
    other_->heard = now;
    other_->proofs += unexplained ? 1 : 0;
  } else if (unexplained) {
    other_ = Other{offset, stamp, now, now, 1};
  } else {
    other_.reset();
  }
  return other_ && other_->proofs >= kProofs && now - other_->since >= kSettle;
}

/// Judges a message by the clock that the newest messages show.
StampClock::Check StampClock::set_clock(double stamp, double now) {
  const double least = 2.0 * one_way_, zero = other_->least - least;
  reset();
  heard_ = now;
  zero_ = zero;
  Check result = judge(stamp, now, least);
  result.clock_set = true;
  return result;
}

StampClock::Check StampClock::check(double stamp, double now) {
  drift(now);
  const std::optional<double> echoed = echoes_.age(stamp, now);
  const double least = echoed ? 0.0 : 2.0 * one_way_;
  if (echoed) zero_ = now - stamp - *echoed;
  if (!zero_) zero_ = now - stamp - least;
  Check result = judge(stamp, now, least);
  if (echoed || result.verdict == Verdict::kUsable)
    other_.reset();
  else if (was_set(stamp, now, result.verdict))
    result = set_clock(stamp, now);
  late_ = result.verdict == Verdict::kLate;
  result.other_clock = echoed && std::abs(*echoed) > kOtherClock;
  return result;
}

}  // namespace palpate

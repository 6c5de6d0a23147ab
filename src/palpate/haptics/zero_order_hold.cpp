#include <palpate/haptics/zero_order_hold.h>

#include <limits>

namespace palpate {

void ZeroOrderHold::reset() { ++beginning_; }

ForceOutput ZeroOrderHold::evaluate(const ForceInput& input) {
  t_ += input.dt;
  question_.back() = {input, t_, beginning_};
  question_.publish();
  answer_.update();
  ForceOutput held;
  if (answer_.front().beginning == beginning_) {
    held = answer_.front().output;
  } else {
    held.proxy = input.tool;
    held.is_known = false;
  }
  held.stored_energy = std::numeric_limits<double>::quiet_NaN();
  return held;
}

void ZeroOrderHold::take() {
  asked_ = question_.update();
  if (asked_) taken_ = question_.front();
}

void ZeroOrderHold::finish() {
  if (!asked_) return;
  const bool first = taken_.beginning != asked_since_;
  if (first) model_.reset();
  ForceInput input = taken_.input;
  input.dt = first ? 0.0 : taken_.t - asked_at_;
  if (contacts_ != nullptr) contacts_->query(input.tool, found_);
  input.contacts = contacts_ != nullptr ? &found_ : nullptr;
  answer_.back() = {model_.evaluate(input), taken_.beginning};
  answer_.publish();
  asked_at_ = taken_.t;
  asked_since_ = taken_.beginning;
}

}  // namespace palpate

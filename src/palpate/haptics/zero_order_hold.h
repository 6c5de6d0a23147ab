/// \file
/// Zero-order hold of a force model, as in the paper, for comparison.
#pragma once

#include <palpate/base/background_work.h>
#include <palpate/base/triple_buffer.h>
#include <palpate/haptics/force_model.h>
#include <palpate/haptics/tool_query.h>

namespace palpate {

/// Returns the latest output of another force model: a slower thread finds the contacts and computes the
/// force, and the servo thread holds that force until the next arrives (paper, section IV). The force is
/// stale by up to two rounds of that thread, which ContactTracker with a Lookahead avoids: with a hand, a
/// spring delayed by 50 ms oscillates by centimetres.
///
/// One thread calls evaluate() and reset(), another one calls take() and finish().
class ZeroOrderHold final : public ForceModel, public BackgroundWork {
 public:
  /// All arguments must outlive this object, and are used only by take() and finish(). \param contacts null
  /// if the model wants none
  ZeroOrderHold(ForceModel& model, ToolTracker* contacts) : model_(model), contacts_(contacts) {
    found_.contacts.reserve(ToolTracker::kRoom);
  }

  bool wants_contacts() const override { return false; }
  /// Starts anew. Results still in flight are discarded.
  void reset() override;
  /// ForceOutput::stored_energy is NaN: the energy in a delayed force is unknown.
  ForceOutput evaluate(const ForceInput& input) override;

  void take() override;
  void finish() override;

 private:
  struct Question {
    ForceInput input;
    double t = 0.0;          ///< sum of the steps. Unit: [s].
    unsigned beginning = 0;  ///< number of reset() calls before
  };
  struct Answer {
    ForceOutput output;
    unsigned beginning = 0;
  };

  ForceModel& model_;
  ToolTracker* contacts_;
  TripleBuffer<Question> question_;
  TripleBuffer<Answer> answer_;
  // Used by the servo thread.
  double t_ = 0.0;
  unsigned beginning_ = 1;
  // Used by the other thread.
  Question taken_;
  bool asked_ = false;  ///< a question was taken in this round
  ContactSet found_;
  double asked_at_ = 0.0;     ///< Unit: [s].
  unsigned asked_since_ = 0;  ///< Question::beginning of the last question
};

}  // namespace palpate

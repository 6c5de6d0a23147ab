/// \file
/// The zero-order hold of the paper, to compare with.
#pragma once

#include <palpate/base/background_work.h>
#include <palpate/base/triple_buffer.h>
#include <palpate/haptics/force_model.h>
#include <palpate/haptics/tool_query.h>

namespace palpate {

/// A force model that answers with what another one felt a while ago: a slower thread looks for the contacts
/// and computes the force, and the servo holds that force until the next is there (paper, section IV). The
/// force is stale by up to two rounds of that thread, which is what ContactTracker with a Lookahead avoids:
/// held by a hand, a spring that is late by 50 ms swings by centimetres.
///
/// One thread calls evaluate() and reset(), another one take() and finish().
class ZeroOrderHold final : public ForceModel, public BackgroundWork {
 public:
  /// All must outlive it, and are used by take() and finish() alone. \param contacts null if the model wants
  /// none
  ZeroOrderHold(ForceModel& model, ToolTracker* contacts) : model_(model), contacts_(contacts) {
    found_.contacts.reserve(ToolTracker::kRoom);
  }

  bool wants_contacts() const override { return false; }
  /// What is being computed at that moment is not for the new beginning, and not told.
  void reset() override;
  /// ForceOutput::stored_energy is NaN: nothing is known of the energy in a force that is late.
  ForceOutput evaluate(const ForceInput& input) override;

  void take() override;
  void finish() override;

 private:
  struct Question {
    ForceInput input;
    double t = 0.0;          ///< sum of the steps. Unit: [s].
    unsigned beginning = 0;  ///< how often reset() was called before
  };
  struct Answer {
    ForceOutput output;
    unsigned beginning = 0;
  };

  ForceModel& model_;
  ToolTracker* contacts_;
  TripleBuffer<Question> question_;
  TripleBuffer<Answer> answer_;
  // Of the servo thread.
  double t_ = 0.0;
  unsigned beginning_ = 1;
  // Of the other one.
  Question taken_;
  bool asked_ = false;  ///< something, in this round
  ContactSet found_;
  double asked_at_ = 0.0;     ///< Unit: [s].
  unsigned asked_since_ = 0;  ///< Question::beginning of the last question
};

}  // namespace palpate

/// \file
/// Ages of stamped messages of a publisher.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include <palpate/gateway/client_clock.h>

namespace palpate {

/// Estimates the age of messages from their stamps, and which of them to use. The offset between the
/// publisher's clock and the loop's is measured by echoes (ClientClock) if the publisher answers them;
/// otherwise, the shortest delay from the publisher is unknown, assumed to be `one_way`, and the least
/// `arrival - stamp` is that of a message with this delay.
///
/// Without echoes, `arrival - stamp` rises by the same amount where the latency rises and where the clock is
/// set back. Messages arrive in the order in which they were sent, so that no latency explains
///
///  - a stamp more than kFuture ahead of the one with the shortest delay, or
///  - a stamp before that of the last usable message.
///
/// A clock was set if at least kProofs such messages have come, and only messages that continue them, for
/// kSettle; the shortest delay is then assumed to be `one_way` again, as for a new publisher. In every other
/// case late messages count as late, however long they are: the estimate rises by no more than kDrift, and
/// not at all while messages are late.
///
/// An age includes the latency of the answer, so that it is the age of a pose when the motors respond to it,
/// as the passivity margin requires. Used by one thread; does not allocate.
class StampClock {
 public:
  enum class Verdict : std::uint8_t {
    kUsable,
    kLate,    ///< older than the age limit, or not newer than the last usable message
    kFuture,  ///< more than kFuture ahead
  };
  struct Check {
    Verdict verdict = Verdict::kUsable;
    double age = 0.0;          ///< Unit: [s]. >= 0
    bool other_clock = false;  ///< by echoes, the stamp is more than kOtherClock from the present
    bool clock_set = false;    ///< with this message the publisher's clock is known to have been set
  };

  /// \param one_way shortest delay from the publisher to this host. Unit: [s]. \param age_limit of usable
  /// messages. Unit: [s].
  StampClock(double one_way, double age_limit) : one_way_(one_way), age_limit_(age_limit) {}

  /// Checks a message with stamp `stamp` that arrived at `now`. Unit: [s]. \pre both are finite; `now` never
  /// decreases.
  Check check(double stamp, double now);

  /// Returns the echo clock, for ClientClock::ask() and answer().
  ClientClock& echoes() { return echoes_; }
  /// Forgets all, for another publisher.
  void reset() { *this = StampClock(one_way_, age_limit_); }

  /// Maximum lead of a stamp. Unit: [s].
  static constexpr double kFuture = 0.05;
  /// Age by echoes beyond which no latency explains it, nor a clock that is ahead: unless the clock was set
  /// within the last two seconds, echoes are answered with another one. Unit: [s].
  static constexpr double kOtherClock = 10.0;
  /// Relative drift of two clocks, each of which is wrong by up to 50 ppm.
  static constexpr double kDrift = 1e-4;
  /// Time for which the messages of a clock that was set are watched before they are used, and the longest
  /// gap between two of them. Unit: [s].
  static constexpr double kSettle = 1.0;
  /// Number of messages that no latency explains: more than one that was sent twice, or wrongly stamped.
  static constexpr int kProofs = 3;

 private:
  static constexpr double kNever = -std::numeric_limits<double>::infinity();

  /// Messages that continue each other, and do not fit the present clock.
  struct Other {
    double least;   ///< `arrival - stamp`. Unit: [s].
    double newest;  ///< stamp. Unit: [s].
    double since;   ///< arrival of the first. Unit: [s].
    double heard;   ///< arrival of the last. Unit: [s].
    int proofs;     ///< how many of them no latency explains
  };

  void drift(double now);
  Check judge(double stamp, double now, double least);
  bool was_set(double stamp, double now, Verdict verdict);
  Check set_clock(double stamp, double now);

  double one_way_, age_limit_;
  ClientClock echoes_;
  std::optional<double> zero_;  ///< `arrival - stamp` of a message of age 0. Unit: [s].
  double newest_ = kNever;      ///< stamp of the last usable message. Unit: [s].
  double used_ = kNever;        ///< its arrival. Unit: [s].
  double heard_ = 0.0;          ///< arrival of the last message. Unit: [s].
  bool late_ = false;           ///< the last message was late
  std::optional<Other> other_;
};

}  // namespace palpate

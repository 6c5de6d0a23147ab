/// \file
/// Clock offset estimation for gateway clients.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

namespace palpate {

/// Estimates the offset between a client's clock and the loop's clock by echoes: a number is sent at t1, the
/// client answers with its own time s, and the answer arrives at t4. On the loop's clock s lies between t1
/// and t4. It is taken to be t1, so that the age of a stamp is never underestimated, and is overestimated by
/// the latency to the client, which equals the latency of the wrench that answers a pose. The age of a pose
/// is therefore its age when the client's motors respond to it.
///
/// Uses the shortest of the last kKept round trips (RFC 5905, section 10, clock filter). Used by one thread.
class ClientClock {
 public:
  /// Starts an echo at time `t`. \returns its number. Unit: [s].
  std::uint64_t ask(double t);
  /// Takes the answer to echo `number`, which carries the client's time `stamp` and arrived at `t`.
  /// Unsolicited and duplicate answers are ignored. Unit: [s].
  void answer(std::uint64_t number, double stamp, double t);

  /// Returns the age of a message with stamp `stamp` that arrives at `t`; nothing if no echo was answered
  /// within kGood. Unit: [s].
  std::optional<double> age(double stamp, double t) const;
  /// Returns the shortest recent round trip; infinite if there is none. Unit: [s].
  double round_trip() const { return best_.round_trip; }

  static constexpr std::size_t kKept = 16;
  /// Validity of an echo: after this time two clocks may have drifted by 0.1 ms, at 20 ppm. Unit: [s].
  static constexpr double kGood = 5.0;

 private:
  struct Echo {
    std::uint64_t number = 0;
    double asked = 0.0, stamp = 0.0;
    double round_trip = std::numeric_limits<double>::infinity();  ///< infinite until answered
  };

  std::array<Echo, kKept> echoes_;  ///< indexed by number modulo kKept
  std::uint64_t count_ = 0;
  Echo best_;
};

}  // namespace palpate

/// \file
/// What the stamps of a client say on this machine's clock.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

namespace palpate {

/// Compares a client's clock with the loop's by echoes: a number goes out at t1, the client answers with its
/// own time s, and that comes at t4. On the loop's clock s was between t1 and t4. Here it is taken for t1, so
/// that what a stamp is found to be old is never too little, and is too much by what the way to the client
/// takes: which is what the answer to a pose takes, too. The age of a pose is therefore how old it is when
/// the client's motors answer it.
///
/// The shortest of the last kKept round trips counts (RFC 5905, 10, the clock filter). Used by one thread.
class ClientClock {
 public:
  /// \returns the number of an echo that is asked for at `t`. Unit: [s].
  std::uint64_t ask(double t);
  /// The client's clock said `stamp` when it answered `number`; that came at `t`. What was not asked for, or
  /// is answered twice, is left out. Unit: [s].
  void answer(std::uint64_t number, double stamp, double t);

  /// How old what was stamped `stamp` is when it comes at `t`; nothing where no echo has come back within
  /// kGood. Unit: [s].
  std::optional<double> age(double stamp, double t) const;
  /// The shortest of the last. Unit: [s]; infinite where there is none.
  double round_trip() const { return best_.round_trip; }

  static constexpr std::size_t kKept = 16;
  /// After which two clocks may be apart by a tenth of a millisecond again, at 20 ppm. Unit: [s].
  static constexpr double kGood = 5.0;

 private:
  struct Echo {
    std::uint64_t number = 0;
    double asked = 0.0, stamp = 0.0;
    double round_trip = std::numeric_limits<double>::infinity();  ///< until it is back
  };

  std::array<Echo, kKept> echoes_;  ///< by number
  std::uint64_t count_ = 0;
  Echo best_;
};

}  // namespace palpate

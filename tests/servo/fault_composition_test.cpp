// Faults, releases and live changes, in any order and at any time after each other.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <ostream>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/servo/safety_governor.h>
#include <support/effort.h>
#include <support/tick.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::is_long;
using test::kTick;

/// What may happen. The first kFaultCount - 1 are stop(), of each fault.
enum class Event : std::uint8_t {
  kNanPose = kFaultCount,
  kNanForce,
  kLateContacts,
  kSilence,  ///< for 30 ms
  kGap,      ///< of 30 ms between two ticks
  kJump,
  kResume,
  kUnpause,
  kEnd
};

std::vector<Event> events() {
  std::vector<Event> all;
  for (unsigned k = 1; k < static_cast<unsigned>(Event::kEnd); ++k) all.push_back(static_cast<Event>(k));
  return all;
}

struct Step {
  double t;  ///< from the first step. Unit: [s].
  Event event;
};

void PrintTo(const Step& step, std::ostream* out) {
  *out << "event " << static_cast<int>(step.event) << " at " << step.t;
}

/// A governor, and what is known of the faults that it has been shown.
class Witness {
 public:
  explicit Witness(std::uint32_t seed) : random_(seed), governor_(limits_) {}

  /// To some state: waiting, rising or active, by chance.
  void begin() {
    static constexpr std::array<double, 4> kUntil{0.01, 0.2, 0.7, 0.7};
    run(kUntil[random_() % kUntil.size()], Vector3d(0, 0, 0.1));
    run(0.02, Vector3d(3, 0, -6));
  }

  /// \returns what was violated, empty if nothing.
  std::string go(const std::vector<Step>& steps, double until) {
    const double begin = t_;
    std::size_t next = 0;
    while (t_ < begin + until) {
      tick_ = {};
      for (; next < steps.size() && t_ - begin >= steps[next].t; ++next) happen(steps[next].event);
      const std::string wrong = tick(Vector3d(3, 0, -6));
      if (!wrong.empty()) return wrong;
    }
    return {};
  }

 private:
  /// What happens in a tick.
  struct Tick {
    bool nan_pose = false, nan_force = false, late_contacts = false, jump = false;
    double gap = 0.0;
  };

  void run(double seconds, const Vector3d& wanted) {
    for (const double end = t_ + seconds; t_ < end;) {
      tick_ = {};
      EXPECT_EQ(tick(wanted), "");
    }
  }

  void happen(Event event) {
    switch (event) {
      case Event::kNanPose: tick_.nan_pose = true; break;
      case Event::kNanForce: tick_.nan_force = true; break;
      case Event::kLateContacts: tick_.late_contacts = true; break;
      case Event::kSilence: silent_until_ = t_ + 0.03; break;
      case Event::kGap: tick_.gap = 0.03; break;
      case Event::kJump: tick_.jump = true; break;
      case Event::kResume:
        governor_.resume();
        std::erase_if(held_, [&](Fault fault) { return !is_raised_now(fault); });
        break;
      case Event::kUnpause:
        governor_.unpause();
        if (!is_raised_now(Fault::kPaused)) std::erase(held_, Fault::kPaused);
        break;
      default: {
        const auto fault = static_cast<Fault>(event);
        governor_.stop(fault);
        see(fault);
      }
    }
  }

  bool is_raised_now(Fault fault) const {
    return std::find(seen_.begin(), seen_.end(), fault) != seen_.end();
  }

  void see(Fault fault) {
    seen_.push_back(fault);
    if (traits(fault).latched) held_.push_back(fault);
  }

  std::string tick(const Vector3d& wanted) {
    // Within what a loop may do; one in a hundred is late.
    static constexpr std::array<double, 4> kPeriods{0.25e-3, 1e-3, 1e-3, 1.3e-3};
    t_ += tick_.gap + (random_() % 100 == 0 ? 2.5e-3 : kPeriods[random_() % kPeriods.size()]);
    if (tick_.gap > 0.0) see(Fault::kLateTick);
    if (tick_.nan_pose) see(Fault::kBadPose);
    if (tick_.nan_force) see(Fault::kBadForce);
    if (tick_.late_contacts) see(Fault::kLateContacts);
    if (t_ > silent_until_) said_.t = t_;
    if (tick_.jump && said_.t == t_) {
      said_.pose.position.y() += 0.5;
      see(Fault::kJump);
    }
    said_.pose.position.x() = 1e-5 * std::sin(100.0 * t_);
    DeviceReading reading = said_;
    if (tick_.nan_pose) reading.pose.position.x() = std::numeric_limits<double>::quiet_NaN();
    governor_.admit(reading, t_);
    Wrench asked{wanted, 0.05 * wanted};
    if (tick_.nan_force) asked.torque.y() = std::numeric_limits<double>::infinity();
    const Wrench sent = governor_.release(asked, tick_.late_contacts ? 1.0 : 0.0);
    for (const Fault fault : seen_) zero_by_ = std::min(zero_by_, t_ + traits(fault).fall_time);
    if (!seen_.empty()) last_seen_ = t_;
    seen_.clear();
    const std::string wrong = judge(sent);
    sent_ = sent;
    return wrong;
  }

  std::string judge(const Wrench& sent) {
    const GovernorState state = governor_.state();
    const bool free = state == GovernorState::kWaiting || state == GovernorState::kRising ||
                      state == GovernorState::kActive;
    const bool zero = sent.force.isZero(0.0) && sent.torque.isZero(0.0);
    if (free != (governor_.fault() == Fault::kNone))
      return "a fault that is not told, or told without a reason";
    if (zero_by_ < kNever && free && state != GovernorState::kWaiting) return "round the gate";
    if (zero_by_ < kNever && free && t_ - last_seen_ < limits_.recover_after) return "back too soon";
    if (free && !held_.empty()) return "back without a resume";
    if (!free && sent.force.norm() > sent_.force.norm()) return "the force has risen in a fall";
    if (!free && sent.torque.norm() > sent_.torque.norm()) return "the torque has risen in a fall";
    if (!free && t_ >= zero_by_ && !zero) return "not zero in the shortest time";
    if (state == GovernorState::kWaiting && !zero) return "force before the gate";
    if (free) zero_by_ = kNever;  // in the gate
    if (state == GovernorState::kWaiting) risen_at_ = t_;
    const double share = std::min(1.0, (t_ - risen_at_) / limits_.rise_time);
    if (state == GovernorState::kRising && sent.force.norm() > share * limits_.force_max + 1e-9)
      return "risen too fast";
    return {};
  }

  static DeviceCapabilities device() {
    DeviceCapabilities d;
    d.force_max = 8.0;
    d.torque_max = 0.4;
    return d;
  }
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  std::mt19937 random_;
  SafetyLimits limits_ = SafetyLimits::of(device(), kTick);
  SafetyGovernor governor_;
  double t_ = 10.0, silent_until_ = 0.0, last_seen_ = 0.0, zero_by_ = kNever, risen_at_ = 0.0;
  Tick tick_;
  DeviceReading said_;
  Wrench sent_;
  std::vector<Fault> seen_;  ///< in this tick
  std::vector<Fault> held_;  ///< latched, and nobody has resumed them
};

/// Long enough for a fall, the way back and the gate.
constexpr double kUntil = 0.8;

void check_sequence(const std::vector<Step>& steps, std::uint32_t seed) {
  Witness witness(seed);
  witness.begin();
  const std::string wrong = witness.go(steps, steps.back().t + kUntil);
  ASSERT_EQ(wrong, "") << testing::PrintToString(steps) << ", seed " << seed;
}

TEST(FaultComposition, PairsAtEveryOffset) {
  const int every = is_long() ? 1 : 7;  // ms; coprime with the periods of the falls
  std::uint32_t seed = 0;
  for (const Event first : events())
    for (const Event second : events())
      for (int offset = static_cast<int>(seed % every); offset <= 150; offset += every)
        ASSERT_NO_FATAL_FAILURE(check_sequence({{0.0, first}, {1e-3 * offset, second}}, ++seed));
}

TEST(FaultComposition, TriplesAtAnyOffset) {
  std::mt19937 random(18);
  const auto offset = [&] { return 1e-3 * static_cast<double>(random() % 151); };
  std::uint32_t seed = 1'000'000;
  const int times = is_long() ? 100 : 1;
  for (const Event first : events())
    for (const Event second : events())
      for (const Event third : events())
        for (int k = 0; k < times; ++k) {
          const double to_second = offset(), to_third = to_second + offset();
          ASSERT_NO_FATAL_FAILURE(
              check_sequence({{0.0, first}, {to_second, second}, {to_third, third}}, ++seed));
        }
}

}  // namespace
}  // namespace palpate

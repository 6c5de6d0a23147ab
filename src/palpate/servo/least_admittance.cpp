#include <palpate/servo/least_admittance.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include <palpate/base/error.h>

namespace palpate {
namespace {

using Complex = std::complex<double>;

/// Largest change of the argument between two samples: beyond it, a sample is inserted. Unit: [rad].
constexpr double kMostTurn = 0.3;
/// Factor above all poles and crossings at which the argument is near its limit. A zero in the right
/// half-plane changes it by pi or more, so that a third of that distinguishes the two.
constexpr double kFarOff = 30.0, kNear = 1.0;
/// Search range. Unit: [kg], [N s/m]; about an axis [kg m^2] and so on.
constexpr double kLeastMass = 1e-3, kMostMass = 1e3, kMostDamping = 1e5;

/// The characteristic function without denominators.
class Characteristic {
 public:
  Characteristic(const AxisAdmittance& a, const AdmittanceLoopModel& l, double gain)
      : a_(a), l_(l), gain_(gain) {}

  /// \param late set to the magnitude of the delayed terms relative to the others
  Complex at(double w, double& late) const {
    const Complex s(0.0, w);
    const Complex drive = 1.0 + s * l_.lag, sensor = 1.0 + s * l_.sensor_lag;
    Complex zero = 1.0, poles = 1.0;
    if (l_.resonance > 0.0) {
      zero = 1.0 + 2.0 * l_.resonance_damping * s / l_.resonance;
      poles = zero + s * s / (l_.resonance * l_.resonance);
    }
    const Complex contact = (l_.contact_stiffness + s * l_.contact_damping) * sensor;
    const Complex hand = s * s * l_.hand_mass + s * l_.hand_damping + l_.hand_stiffness;
    const Complex prompt = s * (s * a_.mass + a_.damping) * drive * sensor * poles;
    const Complex delayed = gain_ * (contact + hand) * zero;
    late = std::abs(delayed) / std::abs(prompt);
    return prompt + delayed * std::exp(-s * l_.delay);
  }

  Complex at(double w) const {
    double late = 0.0;
    return at(w, late);
  }

  int degree() const {
    return 2 + (l_.lag > 0.0 ? 1 : 0) + (l_.sensor_lag > 0.0 ? 1 : 0) + (l_.resonance > 0.0 ? 2 : 0);
  }

  /// Frequency above all poles and crossings. Unit: [rad/s].
  double highest() const {
    const double hand = gain_ * l_.hand_mass / a_.mass,
                 stiffness = gain_ * (l_.contact_stiffness + l_.hand_stiffness);
    double w = std::sqrt(stiffness / a_.mass) + a_.damping / a_.mass + l_.resonance +
               gain_ * (l_.hand_damping + l_.contact_damping) / a_.mass;
    for (const double lag : {l_.lag, l_.sensor_lag})
      if (lag > 0.0) w += (1.0 + hand) / lag;
    return kFarOff * std::max(w, 1.0);
  }

 private:
  const AxisAdmittance& a_;
  const AdmittanceLoopModel& l_;
  double gain_;
};

/// Change of the argument from one frequency to another, sampled finely enough not to miss a turn.
double turn(const Characteristic& p, double from, const Complex& at_from, double to, const Complex& at_to,
            int depth) {
  const double whole = std::arg(at_to / at_from);
  if (depth == 0 || (std::abs(whole) < kMostTurn && std::abs(at_to) < 3.0 * std::abs(at_from) &&
                     std::abs(at_from) < 3.0 * std::abs(at_to)))
    return whole;
  const double middle = std::sqrt(from * to);
  const Complex at_middle = p.at(middle);
  return turn(p, from, at_from, middle, at_middle, depth - 1) +
         turn(p, middle, at_middle, to, at_to, depth - 1);
}

bool is_stable_at(const AxisAdmittance& a, const AdmittanceLoopModel& l, double gain) {
  if (!(a.mass > 0.0 && a.damping >= 0.0)) return false;
  const double stiffness = l.contact_stiffness + l.hand_stiffness;
  const bool neutral = l.lag == 0.0 && l.sensor_lag == 0.0;
  if (neutral && gain * l.hand_mass >= a.mass) return false;
  if (stiffness == 0.0 && a.damping + gain * (l.hand_damping + l.contact_damping) == 0.0) return false;
  const Characteristic p(a, l, gain);
  // A free handle has a zero at s = 0: its argument of pi / 2 is subtracted, and the other zeros are counted.
  const double lowest = 1e-4, highest = p.highest();
  constexpr int kDeepest = 12;
  constexpr double kRatio = 1.1;
  double total = std::arg(p.at(lowest));  // from s = 0, where it is positive
  if (stiffness == 0.0) total -= 0.5 * std::numbers::pi;
  double from = lowest;
  Complex at_from = p.at(from);
  // If the delayed term matters, each of its turns is sampled.
  const double fine = l.delay > 0.0 ? 0.5 / l.delay : std::numeric_limits<double>::infinity();
  constexpr double kCounts = 0.1;
  double late = std::numeric_limits<double>::infinity();
  while (from < highest) {
    const double to = late > kCounts ? std::min(from * kRatio, from + fine) : from * kRatio;
    const Complex at_to = p.at(to, late);
    total += turn(p, from, at_from, to, at_to, late > kCounts ? kDeepest : 0);
    from = to;
    at_from = at_to;
  }
  const double zeros = stiffness == 0.0 ? p.degree() - 1 : p.degree();
  return std::abs(total - zeros * 0.5 * std::numbers::pi) < kNear;
}

/// Also checks weaker hands and contacts, and a released handle: a stronger hand may be what makes a loop
/// stable.
bool is_stable_with_margin(const AxisAdmittance& a, const AdmittanceLoopModel& l, double margin) {
  if (!is_stable_at(a, l, 1.0)) return false;
  if (margin == 1.0) return true;
  AdmittanceLoopModel let_go = l;
  let_go.hand_mass = let_go.hand_damping = let_go.hand_stiffness = 0.0;
  for (const double gain : {margin, std::sqrt(margin)})
    if (!is_stable_at(a, l, gain) || !is_stable_at(a, let_go, gain)) return false;
  return let_go.contact_stiffness == 0.0 || is_stable_at(a, let_go, 1.0);
}

}  // namespace

bool is_stable(const AxisAdmittance& admittance, const AdmittanceLoopModel& loop) {
  return is_stable_at(admittance, loop, 1.0);
}

double gain_margin(const AxisAdmittance& admittance, const AdmittanceLoopModel& loop) {
  if (!is_stable(admittance, loop)) return 0.0;
  double low = 1.0, high = kMostMargin;
  if (is_stable_at(admittance, loop, high)) return high;
  for (int k = 0; k < 30; ++k) {
    const double middle = std::sqrt(low * high);
    (is_stable_at(admittance, loop, middle) ? low : high) = middle;
  }
  return low;
}

double least_damping(double mass, const AdmittanceLoopModel& loop, double margin) {
  if (is_stable_with_margin({mass, 0.0}, loop, margin)) return 0.0;
  if (!is_stable_with_margin({mass, kMostDamping}, loop, margin))
    return std::numeric_limits<double>::infinity();
  double low = 1e-4, high = kMostDamping;
  for (int k = 0; k < 24; ++k) {
    const double middle = std::sqrt(low * high);
    (is_stable_with_margin({mass, middle}, loop, margin) ? high : low) = middle;
  }
  return high;
}

AxisAdmittance least_admittance(const AdmittanceLoopModel& loop, double margin) {
  constexpr int kMasses = 30;
  AxisAdmittance best{kMostMass, std::numeric_limits<double>::infinity()};
  const auto felt = [](const AxisAdmittance& a) { return std::hypot(kFreeMotion * a.mass, a.damping); };
  for (int k = 0; k <= kMasses; ++k) {
    const double mass = kLeastMass * std::pow(kMostMass / kLeastMass, static_cast<double>(k) / kMasses);
    if (kFreeMotion * mass > felt(best)) break;
    const AxisAdmittance tried{mass, least_damping(mass, loop, margin)};
    if (felt(tried) < felt(best)) best = tried;
  }
  return best;
}

double passive_damping(const AdmittanceLoopModel& loop) {
  return loop.contact_stiffness * (loop.delay + loop.lag + loop.sensor_lag) + loop.contact_damping;
}

void require_stable(const AxisAdmittance& admittance, const AdmittanceLoopModel& loop,
                    const std::string& name, double margin) {
  if (!(admittance.mass > 0.0))
    throw Error("{}: the virtual mass is {}; it must be positive", name, admittance.mass);
  if (!(admittance.damping >= 0.0))
    throw Error("{}: the virtual damping is {}; it must not be negative", name, admittance.damping);
  if (is_stable_with_margin(admittance, loop, margin)) return;
  const double damping = least_damping(admittance.mass, loop, margin);
  const AxisAdmittance least = least_admittance(loop, margin);
  throw Error(
      "{}: a virtual mass of {:.3g} and damping of {:.3g} are not stable at {:.4g} N/m and a delay of {:.3g} "
      "ms; this mass needs a damping of {:.3g}; the lightest stable pair is a mass of {:.3g} and damping of "
      "{:.3g}",
      name, admittance.mass, admittance.damping, loop.contact_stiffness, 1e3 * loop.delay, damping,
      least.mass, least.damping);
}

}  // namespace palpate

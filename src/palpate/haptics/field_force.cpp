#include <palpate/haptics/field_force.h>

#include <cmath>

namespace palpate {
namespace {

constexpr double kPower = 3.0;                                   // p
constexpr double kEvenSpread = (kPower + 2.0) / (kPower + 1.0);  // c

/// e of one contact: 1 - sqrt(1 - K), without cancellation.
double shrinkage(const Contact& contact) { return contact.k_min / (1.0 + std::sqrt(1.0 - contact.k_min)); }

double cube(double x) { return x * x * x; }

/// sum alpha e^p and sum alpha e^(p+1).
struct Sums {
  double weight = 0.0, weighted = 0.0;

  explicit Sums(const ContactSet& contacts) {
    for (const Contact& c : contacts.contacts) {
      const double e = shrinkage(c), w = c.opacity * cube(e);
      weight += w;
      weighted += w * e;
    }
  }
};

}  // namespace

FieldDepth field_depth(const ContactSet& contacts, const Eigen::Vector3d& tool_center, double a_min) {
  const Sums sums(contacts);
  FieldDepth result;
  if (!(sums.weight > 0.0)) return result;  // none, or so shallow that nothing is left of them
  const double mean = sums.weighted / sums.weight, length = kEvenSpread * a_min;
  result.depth = length * mean;
  for (const Contact& c : contacts.contacts) {
    // 1 - K = l (1 - l) d^T y and dK/dx = -2 l (1 - l) y with y = M^-1 d along the normal n (envelope
    // theorem): |dK/dx| = 2 (1 - K) / (d . n), and |de/dx| = sqrt(1 - K) / (d . n). Where centres coincide
    // there is no way out, hence no force.
    const double apart = (tool_center - c.center).dot(c.normal);
    if (!(apart > 0.0)) continue;
    const double e = shrinkage(c);
    const double of_e =
        c.opacity * e * e * ((kPower + 1.0) * e - kPower * mean) / sums.weight;  // d mean / d e
    const Eigen::Vector3d gradient = -(length * of_e * std::sqrt(1.0 - c.k_min) / apart) * c.normal;
    result.gradient += gradient;
    // Turning the tool moves its mass at m(lambda) against the Gaussian as translating it would.
    result.turning += (c.point - tool_center).cross(gradient);
  }
  return result;
}

double FieldForce::potential(const ForceInput& input) const {
  const double depth = field_depth(*input.contacts, input.tool.position, a_min_).depth;
  return 0.5 * parameters_.stiffness * depth * depth;
}

ForceOutput FieldForce::evaluate(const ForceInput& input) {
  const FieldDepth field = field_depth(*input.contacts, input.tool.position, a_min_);
  const double push = -parameters_.stiffness * field.depth;
  return {{push * field.gradient, push * field.turning}, input.tool};
}

}  // namespace palpate

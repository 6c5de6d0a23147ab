#include <palpate/haptics/field_force.h>

#include <cmath>

namespace palpate {
namespace {

constexpr double kPower = 3.0;                                   // p
constexpr double kEvenSpread = (kPower + 2.0) / (kPower + 1.0);  // c
constexpr double kCore = 0.25;                                   // s / a

double cube(double x) { return x * x * x; }

/// L of a part, and how it changes.
struct Reach {
  double length;            ///< Unit: [m].
  Eigen::Vector3d by_r;     ///< dL / dr
  Eigen::Vector3d by_turn;  ///< by a turn of the part about its own centre. Unit: [m].

  Reach(const Ellipsoid& part, double a_min, const Eigen::Vector3d& r) {
    const double core = kCore * kCore * a_min * a_min;
    const Eigen::Vector3d b = part.axes * (part.axes.transpose() * r);
    const double below = r.squaredNorm() + core;
    length = std::sqrt((r.dot(b) + core * a_min * a_min) / below);
    by_r = (b - length * length * r) / (length * below);
    by_turn = b.cross(r) / (length * below);
  }
};

/// Visits each contact with the part of the tool that it is of: visit(contact, solid, shortest semi-axis).
template <class Visit>
void for_each_contact(const ContactSet& contacts, const Tool& tool, const Pose& pose, const Visit& visit) {
  const auto parts = tool.parts();
  std::uint32_t last = 0;
  Ellipsoid solid = parts[0].at(pose);
  for (const Contact& c : contacts.contacts) {
    if (c.part != last) solid = parts[last = c.part].at(pose);
    visit(c, solid, parts[last].semi_axes.minCoeff());
  }
}

/// 1 - sqrt(1 - K), without cancellation.
double shrinkage(const Contact& contact) { return contact.k_min / (1.0 + std::sqrt(1.0 - contact.k_min)); }

}  // namespace

FieldDepth field_depth(const ContactSet& contacts, const Tool& tool, const Pose& pose) {
  double weight = 0.0, weighted = 0.0;  // of (e L)^p, and of (e L)^(p+1)
  for_each_contact(contacts, tool, pose, [&](const Contact& c, const Ellipsoid& solid, double a_min) {
    const double x = shrinkage(c) * Reach(solid, a_min, solid.center - c.center).length;
    weight += c.opacity * cube(x);
    weighted += c.opacity * cube(x) * x;
  });
  FieldDepth result;
  if (!(weight > 0.0)) return result;  // none, or so shallow that nothing is left of them
  const double mean = weighted / weight;
  result.depth = kEvenSpread * mean;
  for_each_contact(contacts, tool, pose, [&](const Contact& c, const Ellipsoid& solid, double a_min) {
    // 1 - K = l (1 - l) d^T y and dK/dx = -2 l (1 - l) y with y = M^-1 d along the normal n (envelope
    // theorem): |dK/dx| = 2 (1 - K) / (d . n), and |de/dx| = sqrt(1 - K) / (d . n). Where centres coincide
    // there is no way out, hence no force.
    const Eigen::Vector3d r = solid.center - c.center;
    const double apart = r.dot(c.normal);
    if (!(apart > 0.0)) return;
    const Reach reach(solid, a_min, r);
    const double e = shrinkage(c), x = e * reach.length;
    const double of_x = kEvenSpread * c.opacity * x * x * ((kPower + 1.0) * x - kPower * mean) / weight;
    // Turning the tool moves its mass at m(lambda) against the Gaussian as translating it would.
    const Eigen::Vector3d by_e = -(of_x * reach.length * std::sqrt(1.0 - c.k_min) / apart) * c.normal;
    const Eigen::Vector3d by_r = of_x * e * reach.by_r;
    result.gradient += by_e + by_r;
    result.turning += (c.point - pose.position).cross(by_e) + (solid.center - pose.position).cross(by_r) +
                      of_x * e * reach.by_turn;
  });
  return result;
}

double FieldForce::potential(const ForceInput& input) const {
  const double depth = field_depth(*input.contacts, tool_, input.tool).depth;
  return 0.5 * parameters_.stiffness * depth * depth;
}

ForceOutput FieldForce::evaluate(const ForceInput& input) {
  const FieldDepth field = field_depth(*input.contacts, tool_, input.tool);
  const double push = -parameters_.stiffness * field.depth;
  return {{push * field.gradient, push * field.turning}, input.tool};
}

}  // namespace palpate

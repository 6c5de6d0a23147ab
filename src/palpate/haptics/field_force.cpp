#include <palpate/haptics/field_force.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace palpate {
namespace {

constexpr double kPower = 3.0;                                   // p
constexpr double kEvenSpread = (kPower + 2.0) / (kPower + 1.0);  // c
constexpr double kCore = 0.01;                                   // s

double cube(double x) { return x * x * x; }

/// 1 - sqrt(1 - K), without cancellation.
double shrinkage(const Contact& contact) { return contact.k_min / (1.0 + std::sqrt(1.0 - contact.k_min)); }

/// Contacts of one part of the tool.
struct PartContacts {
  std::span<const Contact> contacts;
  Eigen::Vector3d center;  ///< of the part. World frame. Unit: [m].
  double weight = 0.0;     ///< sum of alpha e^p
  Eigen::Vector3d r;       ///< mean of center - c_i
  double reach = 0.0;      ///< L. Unit: [m].
  Eigen::Vector3d by_r;    ///< dL / dr

  PartContacts(std::span<const Contact> of_part, const ToolPart& part, const Pose& tool)
      : contacts(of_part), center((tool * part.pose).position), r(Eigen::Vector3d::Zero()) {
    for (const Contact& c : contacts) {
      const double w = c.opacity * cube(shrinkage(c));
      weight += w;
      r += w * (center - c.center);
    }
    if (!(weight > 0.0)) return;
    r /= weight;
    const Eigen::Quaterniond turn = tool.orientation * part.pose.orientation;
    const Eigen::Array3d inverse = part.semi_axes.array().square().inverse();
    const Eigen::Array3d own = (turn.conjugate() * r).array();  // r along the part's axes
    const double a_min = part.semi_axes.minCoeff();
    const double above = (own.square() * inverse).sum() + kCore;
    const double below = (own * inverse).square().sum() + kCore / (a_min * a_min);
    reach = std::sqrt(above / below);
    by_r = turn * Eigen::Vector3d((own * inverse - reach * reach * own * inverse.square()) / (reach * below));
  }
};

/// Visits the parts that touch something, in order: visit(PartContacts).
template <class Visit>
void for_each_part(const ContactSet& contacts, const Tool& tool, const Pose& pose, const Visit& visit) {
  std::span<const Contact> rest(contacts.contacts);
  while (!rest.empty()) {
    const std::uint32_t part = rest.front().part;
    const auto other =
        std::find_if(rest.begin(), rest.end(), [&](const Contact& c) { return c.part != part; });
    const auto size = static_cast<std::size_t>(other - rest.begin());
    visit(PartContacts(rest.first(size), tool.parts()[part], pose));
    rest = rest.subspan(size);
  }
}

/// Adds to dD what follows from the contacts of one part. \param mean sum alpha x^(p+1) / sum alpha x^p over
/// the tool, and `weight` the latter sum, x = e L
void add_gradient(const PartContacts& part, double mean, double weight, const Pose& pose,
                  FieldDepth& result) {
  const auto by_x = [&](const Contact& c, double x) {
    return kEvenSpread * c.opacity * x * x * ((kPower + 1.0) * x - kPower * mean) / weight;
  };
  double by_reach = 0.0;  // dD / dL
  for (const Contact& c : part.contacts) {
    const double e = shrinkage(c);
    by_reach += by_x(c, e * part.reach) * e;
  }
  for (const Contact& c : part.contacts) {
    // 1 - K = l (1 - l) d^T y and dK/dx = -2 l (1 - l) y with y = M^-1 d along the normal n (envelope
    // theorem): |dK/dx| = 2 (1 - K) / (d . n), and |de/dx| = sqrt(1 - K) / (d . n). Where centres coincide
    // there is no way out, hence no force.
    const Eigen::Vector3d r = part.center - c.center;
    const double apart = r.dot(c.normal), e = shrinkage(c);
    if (!(apart > 0.0)) continue;
    const double by_e = by_x(c, e * part.reach) * part.reach +
                        by_reach * kPower * c.opacity * e * e * part.by_r.dot(r - part.r) / part.weight;
    const Eigen::Vector3d gradient = -(by_e * std::sqrt(1.0 - c.k_min) / apart) * c.normal;
    result.gradient += gradient;
    // Turning the tool moves its mass at m(lambda) against the Gaussian as translating it would.
    result.turning += (c.point - pose.position).cross(gradient);
  }
  // L follows r, and turns with the part.
  const Eigen::Vector3d gradient = by_reach * part.by_r;
  result.gradient += gradient;
  result.turning += (part.center - pose.position).cross(gradient) + gradient.cross(part.r);
}

}  // namespace

FieldDepth field_depth(const ContactSet& contacts, const Tool& tool, const Pose& pose) {
  double weight = 0.0, weighted = 0.0;  // of x^p, and of x^(p+1)
  for_each_part(contacts, tool, pose, [&](const PartContacts& part) {
    for (const Contact& c : part.contacts) {
      const double x = shrinkage(c) * part.reach;
      weight += c.opacity * cube(x);
      weighted += c.opacity * cube(x) * x;
    }
  });
  FieldDepth result;
  if (!(weight > 0.0)) return result;  // none, or so shallow that nothing is left of them
  const double mean = weighted / weight;
  result.depth = kEvenSpread * mean;
  for_each_part(contacts, tool, pose, [&](const PartContacts& part) {
    if (part.weight > 0.0) add_gradient(part, mean, weight, pose, result);
  });
  return result;
}

/// Where the spring ends and the force is the same from then on. |dD/dx| may be a little above 1. Unit: [m].
double FieldForce::end_of_spring(const ForceInput& input) const {
  constexpr double kHeadroom = 0.9;
  return kHeadroom * input.force_max / parameters_.stiffness;
}

double FieldForce::potential(const ForceInput& input) const {
  const double depth = field_depth(*input.contacts, tool_, input.tool).depth;
  const double within = std::min(depth, end_of_spring(input));
  return parameters_.stiffness * within * (depth - 0.5 * within);
}

ForceOutput FieldForce::evaluate(const ForceInput& input) {
  const FieldDepth field = field_depth(*input.contacts, tool_, input.tool);
  const double k = parameters_.stiffness, within = std::min(field.depth, end_of_spring(input));
  return {{-k * within * field.gradient, -k * within * field.turning},
          input.tool,
          1.0,
          k * within * (field.depth - 0.5 * within),
          field.depth > 0.0 ? k : 0.0};
}

}  // namespace palpate

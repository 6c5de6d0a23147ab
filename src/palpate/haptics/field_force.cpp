#include <palpate/haptics/field_force.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace palpate {
namespace {

constexpr double kPower = 3.0;                                   // p
constexpr double kEvenSpread = (kPower + 2.0) / (kPower + 1.0);  // c
constexpr double kBlunt = 0.5;                                   // g_0
constexpr double kCore = 0.1;                                    // s_0

double cube(double x) { return x * x * x; }

/// Depth e of one contact, in [0, 13/16], and its derivative by f = 1 - K = g^2.
struct Shrinkage {
  double e, by_f;

  explicit Shrinkage(const Contact& contact) {
    const double f = 1.0 - contact.k_min, v = f / (kBlunt * kBlunt);
    if (v < 1.0) {
      e = 1.0 - kBlunt * (3.0 + v * (6.0 - v)) / 8.0;
      by_f = -(3.0 - v) / (4.0 * kBlunt);
    } else {
      const double g = std::sqrt(f);
      e = contact.k_min / (1.0 + g);  // 1 - g, without cancellation
      by_f = -0.5 / g;
    }
  }
};

double shrinkage(const Contact& contact) { return Shrinkage(contact).e; }

/// Vector d from the centre of a Gaussian to that of a touching part, shortened to d / (1 + (q - 1)^3)^(1/6)
/// where q = d^T B^-1 d > 1: what lies farther says less about the direction of the surface.
struct Offset {
  Eigen::Vector3d d, by_d;  ///< d and B^-1 d = dq/dd / 2
  double scale = 1.0, scale_by_q = 0.0;

  Offset(const Eigen::Matrix3d& inverse_shape, const Eigen::Vector3d& apart)
      : d(apart), by_d(inverse_shape * apart) {
    const double beyond = d.dot(by_d) - 1.0;
    if (!(beyond > 0.0)) return;
    const double base = 1.0 + cube(beyond);
    scale = std::pow(base, -1.0 / 6.0);
    scale_by_q = -0.5 * beyond * beyond * scale / base;
  }

  Eigen::Vector3d value() const { return scale * d; }
  /// d(g . value()) / dd
  Eigen::Vector3d by(const Eigen::Vector3d& g) const {
    return scale * g + 2.0 * scale_by_q * d.dot(g) * by_d;
  }
};

/// Contacts of one part of the tool.
struct PartContacts {
  std::span<const Contact> contacts;
  Eigen::Vector3d center;         ///< of the part. World frame. Unit: [m].
  Eigen::Matrix3d inverse_shape;  ///< B^-1. World frame. Unit: [1/m^2].
  double weight = 0.0;            ///< sum of alpha e^p
  Eigen::Vector3d r;              ///< mean of Offset::value()
  double reach = 0.0;             ///< L. Unit: [m].
  Eigen::Vector3d by_r;           ///< dL / dr
  bool round;                     ///< a ball: L is its radius, and r is not computed

  PartContacts(std::span<const Contact> of_part, const ToolPart& part, const Pose& tool)
      : contacts(of_part), center((tool * part.pose).position), r(Eigen::Vector3d::Zero()) {
    const double a_min = part.semi_axes.minCoeff();
    round = part.semi_axes.maxCoeff() == a_min;
    if (round) {
      for (const Contact& c : contacts) weight += c.opacity * cube(shrinkage(c));
      reach = a_min;
      return;
    }
    const Eigen::Matrix3d axes = (tool.orientation * part.pose.orientation).toRotationMatrix();
    inverse_shape = axes * part.semi_axes.cwiseAbs2().cwiseInverse().asDiagonal() * axes.transpose();
    for (const Contact& c : contacts) {
      const double w = c.opacity * cube(shrinkage(c));
      weight += w;
      r += w * Offset(inverse_shape, center - c.center).value();
    }
    if (!(weight > 0.0)) return;
    r /= weight;
    const Eigen::Vector3d n = inverse_shape * r;
    const double q = r.dot(n), within = std::max(0.0, 1.0 - q);
    const double s = kCore * cube(within), s_by_q = -3.0 * kCore * within * within;
    const double below = n.squaredNorm() + s / (a_min * a_min);
    const double squared = (q + s) / below;
    reach = std::sqrt(squared);
    by_r = ((1.0 + s_by_q * (1.0 - squared / (a_min * a_min))) * n - squared * (inverse_shape * n)) /
           (reach * below);
  }
};

/// Visits the parts in contact, in order: visit(PartContacts).
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

/// Adds to dD the terms of the contacts of one part. \param mean sum alpha x^(p+1) / sum alpha x^p over the
/// tool \param weight the latter sum, x = e L
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
  const auto add = [&](const Eigen::Vector3d& gradient, const Eigen::Vector3d& at) {
    result.gradient += gradient;
    result.turning += (at - pose.position).cross(gradient);
  };
  for (const Contact& c : part.contacts) {
    const Shrinkage shrunk(c);
    const Eigen::Vector3d d = part.center - c.center;
    double by_e = by_x(c, shrunk.e * part.reach) * part.reach;
    if (!part.round) {
      const Offset offset(part.inverse_shape, d);
      const double share = c.opacity * shrunk.e * shrunk.e / part.weight;  // weight in r, divided by e
      by_e += by_reach * kPower * share * part.by_r.dot(offset.value() - part.r);
      // Rotating the tool changes d, in the part's frame, as if the Gaussian's centre were a point of the
      // tool.
      add(by_reach * share * shrunk.e * offset.by(part.by_r), c.center);
    }
    // f = 1 - K = l (1 - l) d^T y and df/dx = 2 l (1 - l) y with y = M^-1 d along the normal n (envelope
    // theorem), hence df/dx = 2 f / (d . n) n. That is of the order of d: where centres coincide no direction
    // leads out, and there is no force. Rotating the tool moves its point m(lambda) relative to the Gaussian
    // as translating it would.
    const double apart = d.dot(c.normal);
    if (apart > 0.0) add((by_e * shrunk.by_f * 2.0 * (1.0 - c.k_min) / apart) * c.normal, c.point);
  }
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
  if (!(weight > 0.0)) return result;  // no contacts, or so shallow that their weights vanish
  const double mean = weighted / weight;
  result.depth = kEvenSpread * mean;
  for_each_part(contacts, tool, pose, [&](const PartContacts& part) {
    if (part.weight > 0.0) add_gradient(part, mean, weight, pose, result);
  });
  return result;
}

/// Depth D_m at which the spring ends; beyond, the force is k D_m |dD/dx|. |dD/dx| is at most c for a single
/// Gaussian. Unit: [m].
double FieldForce::end_of_spring(const ForceInput& input) const {
  return input.force_max / (kEvenSpread * parameters_.stiffness);
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
          field.depth > 0.0 ? k : 0.0,
          field.depth > 0.0 ? k * radius_ * radius_ : 0.0,
          true};
}

}  // namespace palpate

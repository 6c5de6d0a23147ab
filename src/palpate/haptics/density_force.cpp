#include <palpate/haptics/density_force.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

/// Weight of the new value in an exponential moving average of time constant `tau` after `dt`. Unit: [s].
double blend(double dt, double tau) { return tau > 0.0 ? -std::expm1(-dt / tau) : 1.0; }

}  // namespace

WeightedContact weighted_contact(std::span<const Contact> contacts) {
  // K is in (0, 1], so that the softmax needs no shift by its largest exponent.
  double total = 0.0;
  WeightedContact sum{Eigen::Vector3d::Zero(), 0.0};
  for (const Contact& c : contacts) {
    const double w = std::exp(c.k_min);
    total += w;
    sum.centroid += w * c.center;
    sum.opacity += w * c.opacity;
  }
  return {sum.centroid / total, sum.opacity / total};
}

void DensityForce::reset() { std::fill(parts_.begin(), parts_.end(), Part{}); }

Eigen::Vector3d DensityForce::force_on(Part& part, const Eigen::Vector3d& center,
                                       const Eigen::Vector3d& velocity, std::span<const Contact> contacts,
                                       const ForceInput& input) const {
  const double dt = input.dt;
  part.velocity += (part.moving ? blend(dt, parameters_.tau_velocity) : 1.0) * (velocity - part.velocity);
  part.moving = true;
  if (contacts.empty()) {
    part.in_contact = false;
    return Eigen::Vector3d::Zero();
  }
  const WeightedContact now = weighted_contact(contacts);
  const Eigen::Vector3d inward = (now.centroid - center).stableNormalized();  // zero stays zero
  if (part.in_contact) {
    part.inward =
        (part.inward + blend(dt, parameters_.tau_direction) * (inward - part.inward)).stableNormalized();
    part.alpha += blend(dt, parameters_.tau_opacity) * (now.opacity - part.alpha);
  } else {
    part.inward = inward;
    part.alpha = now.opacity;
    part.in_contact = true;
  }
  const Eigen::Vector3d outward = -part.inward;
  const double n = static_cast<double>(contacts.size());
  const double elastic = parameters_.k_base * part.alpha * n;  // eqs. 9-10
  const double most = std::min(parameters_.damping, input.damping_max / static_cast<double>(parts_.size()));
  const double damping = -most * outward.dot(part.velocity);               // eq. 10
  return std::clamp(elastic + damping, 0.0, parameters_.f_max) * outward;  // eq. 11
}

ForceOutput DensityForce::evaluate(const ForceInput& input) {
  Wrench wrench;
  std::span<const Contact> rest(input.contacts->contacts);
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const auto other = [k](const Contact& c) { return c.part != k; };
    const auto size = static_cast<std::size_t>(std::find_if(rest.begin(), rest.end(), other) - rest.begin());
    const Eigen::Vector3d lever = input.tool.orientation * tool_.parts()[k].pose.position;
    const Eigen::Vector3d force =
        force_on(parts_[k], input.tool.position + lever,
                 input.velocity.linear + input.velocity.angular.cross(lever), rest.first(size), input);
    wrench.force += force;
    wrench.torque += lever.cross(force);
    rest = rest.subspan(size);
  }
  const double excess = wrench.force.norm() / parameters_.f_max;
  if (excess > 1.0) {
    wrench.force /= excess;
    wrench.torque /= excess;
  }
  return {wrench, input.tool, 1.0, std::numeric_limits<double>::quiet_NaN()};
}

}  // namespace palpate

#include <palpate/haptics/density_force.h>

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

/// Weight of the new value in an exponential moving average of time constant `tau` after `dt`. [s]
double blend(double dt, double tau) { return tau > 0.0 ? -std::expm1(-dt / tau) : 1.0; }

}  // namespace

WeightedContact weighted_contact(const ContactSet& set) {
  const double k_max = set.k_max();
  double total = 0.0;
  WeightedContact sum{Eigen::Vector3d::Zero(), 0.0};
  for (const Contact& c : set.contacts) {
    const double w = std::exp(c.k_min - k_max);
    total += w;
    sum.centroid += w * c.center;
    sum.opacity += w * c.opacity;
  }
  return {sum.centroid / total, sum.opacity / total};
}

void DensityForce::reset() { *this = DensityForce(parameters_); }

ForceOutput DensityForce::evaluate(const ForceInput& input) {
  velocity_ +=
      (moving_ ? blend(input.dt, parameters_.tau_velocity) : 1.0) * (input.velocity.linear - velocity_);
  moving_ = true;

  const std::size_t n = input.contacts->contacts.size();
  if (n == 0) {
    in_contact_ = false;
    return {Wrench{}, input.tool};
  }
  const WeightedContact now = weighted_contact(*input.contacts);
  const Eigen::Vector3d inward = (now.centroid - input.tool.position).stableNormalized();  // zero stays zero
  if (in_contact_) {
    inward_ = (inward_ + blend(input.dt, parameters_.tau_direction) * (inward - inward_)).stableNormalized();
    alpha_ += blend(input.dt, parameters_.tau_opacity) * (now.opacity - alpha_);
  } else {
    inward_ = inward;
    alpha_ = now.opacity;
    in_contact_ = true;
  }
  const Eigen::Vector3d outward = -inward_;
  const double elastic = parameters_.k_base * alpha_ * static_cast<double>(n);     // eqs. 9-10
  const double damping = -parameters_.damping * outward.dot(velocity_);            // eq. 10
  const double magnitude = std::clamp(elastic + damping, 0.0, parameters_.f_max);  // eq. 11
  return {{magnitude * outward, Eigen::Vector3d::Zero()}, input.tool};
}

}  // namespace palpate

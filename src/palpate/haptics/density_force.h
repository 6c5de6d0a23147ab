/// \file
/// The paper's density-based volumetric penalty force (III-C, eqs. 7-11).
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include <palpate/haptics/force_model.h>
#include <palpate/haptics/tool.h>

namespace palpate {

/// Parameters of DensityForce. The paper gives no values; the defaults suit a tool of a few
/// centimetres in a scene of millimetre splats, where contacts number 10 to 100.
struct DensityParameters {
  double k_base = 0.1;          ///< eq. 9, force per colliding Gaussian of opacity 1. Unit: [N]. >= 0
  double damping = 5.0;         ///< eq. 10, D. Unit: [N s/m]. >= 0
  double f_max = 12.0;          ///< eq. 11, the device's peak force (an omega: 12 N). Unit: [N]. > 0
  double tau_direction = 0.01;  ///< time constant of the average of the direction. Unit: [s]. >= 0
  double tau_opacity = 0.01;    ///< time constant of the average of the opacity. Unit: [s]. >= 0
  double tau_velocity = 0.005;  ///< time constant of the velocity filter. Unit: [s]. >= 0

  bool operator==(const DensityParameters&) const = default;
};

/// The paper's model, interpreted as follows:
///
///  - w_i = softmax of K_min,i (eq. 7); p_eff = sum w_i c_i (eq. 8).
///  - The direction from the tool centre to p_eff points into the object; the outward normal is its
///    opposite. Its exponential moving average, in time and not in ticks (weight of the new value
///    1 - exp(-dt/tau)), is normalised again.
///  - alpha_raw = sum w_i alpha_i, averaged likewise, k_eff = k_base alpha (eq. 9).
///  - |F| = clamp(k_eff N - D v_n, 0, F_max) along the outward normal, v_n the filtered velocity along it
///    (eqs. 10-11): moving in (v_n < 0) increases the force, which never attracts. D is at most what the
///    device can render.
///  - The averages start at the first instant of a contact and are discarded at its end; without contact the
///    force is exactly zero. The ellipsoid gets no torque.
///
/// The paper's tool is one ellipsoid. A tool of several gets such a force for every part, at the part's
/// centre; the sum is clamped to F_max again, and the torque is about the handle.
///
/// Reproduces the paper's model, faults included; docs/force-models.md lists them with measurements.
class DensityForce final : public ForceModel {
 public:
  explicit DensityForce(const DensityParameters& parameters = {}) : DensityForce(Tool{}, parameters) {}
  DensityForce(const Tool& tool, const DensityParameters& parameters)
      : tool_(tool), parameters_(parameters), parts_(tool.parts().size()) {}

  void reset() override;
  ForceOutput evaluate(const ForceInput& input) override;

 private:
  /// State of one ellipsoid.
  struct Part {
    bool in_contact = false;
    bool moving = false;                                 ///< velocity holds a value
    Eigen::Vector3d inward = Eigen::Vector3d::Zero();    ///< smoothed unit direction into the object
    double alpha = 0.0;                                  ///< smoothed weighted opacity
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< filtered. Unit: [m/s].
  };

  /// The force on a part at `center` that moves at `velocity` and has these contacts.
  Eigen::Vector3d force_on(Part& part, const Eigen::Vector3d& center, const Eigen::Vector3d& velocity,
                           std::span<const Contact> contacts, const ForceInput& input) const;

  Tool tool_;
  DensityParameters parameters_;
  std::vector<Part> parts_;
};

/// Eqs. 7-8 for one set of contacts: softmax-weighted centroid and opacity.
struct WeightedContact {
  Eigen::Vector3d centroid;  ///< p_eff. Unit: [m].
  double opacity;            ///< alpha_raw
};

/// \pre contacts is not empty.
WeightedContact weighted_contact(std::span<const Contact> contacts);

}  // namespace palpate

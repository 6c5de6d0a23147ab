/// \file
/// A penalty force that is the gradient of a potential.
#pragma once

#include <palpate/haptics/force_model.h>
#include <palpate/haptics/tool.h>

namespace palpate {

/// Parameters of FieldForce.
struct FieldParameters {
  double stiffness = 500.0;  ///< against a surface that is densely covered. Unit: [N/m]. >= 0
};

/// How deep a tool is in what it touches, from the contacts of its pose alone:
///
///     e_i = 1 - sqrt(1 - K_i)       how far both solids would have to shrink, as a factor, to only touch: 0
///     at
///                                   first touch, 1 where centres coincide
///     L   = sqrt((r^T B^-1 r + s) / (r^T B^-2 r + s / a^2)),    r = mean of c_part - c_i by alpha_i e_i^p
///                                   how far the part of the tool reaches along B^-1 r, which is the normal
///                                   of the plane that its contacts lie in
///     D   = c (sum alpha_i (e_i L_i)^(p+1)) / (sum alpha_i (e_i L_i)^p),    p = 3, c = (p + 2) / (p + 1)
///
/// with B the part's shape matrix, a its shortest semi-axis and s = 1 / 100, which keeps L smooth where
/// centres meet; L_i is that of the part that contact i is of, and of a ball the radius. The quotient is a
/// mean in which the deepest count most, so that D depends on where the surface is and not on how many
/// Gaussians it is made of. A Gaussian that comes or goes has e_i = 0 and no weight. Where an ellipsoid is
/// pressed into a plane of points, their e_i are spread evenly from 0 to that of the deepest, which is depth
/// / L: D is then the depth.
///
/// Everything in it is a smooth function of the pose, but for the Gaussians whose centre is the tool's.
struct FieldDepth {
  double depth = 0.0;                                  ///< D. Unit: [m].
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< dD / d(tool position), world frame
  /// dD / d(tool orientation): by the rotation vector of a turn about the handle, world frame. Unit: [m].
  Eigen::Vector3d turning = Eigen::Vector3d::Zero();
};

/// \param contacts of `tool` at `pose`, part by part as query() finds them
FieldDepth field_depth(const ContactSet& contacts, const Tool& tool, const Pose& pose);

/// The conservative model: with U = k D^2 / 2, force = -dU/dx and torque = -dU/dtheta, exactly. No work is
/// done around a closed path; stiffness does not depend on how densely the scene was trained; there is no
/// state.
///
/// Beyond the depth D_m where the force is what the device can show (ForceInput::force_max), U goes on as k
/// D_m (D - D_m / 2): a force that the device cuts off instead is no gradient, and a hand that slides in it
/// and lifts off elsewhere would be given energy.
///
/// It pushes out the way that is nearest where the tool is, so that a push deeper than the middle of a thin
/// object comes out on the other side, as with any force that depends on the pose alone; `proxy` remembers
/// where it came from.
class FieldForce final : public ForceModel {
 public:
  /// \pre contacts passed to evaluate() are those of `tool`, in double precision.
  explicit FieldForce(const Tool& tool, const FieldParameters& parameters = {})
      : tool_(tool), parameters_(parameters) {}

  void reset() override {}
  ForceOutput evaluate(const ForceInput& input) override;

  /// U. Unit: [J].
  double potential(const ForceInput& input) const;

 private:
  double end_of_spring(const ForceInput& input) const;

  Tool tool_;
  FieldParameters parameters_;
};

}  // namespace palpate

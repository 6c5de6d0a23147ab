/// \file
/// Conservative penalty force: the gradient of a potential.
#pragma once

#include <palpate/haptics/force_model.h>
#include <palpate/haptics/tool.h>

namespace palpate {

/// Parameters of FieldForce.
struct FieldParameters {
  double stiffness = 500.0;  ///< against a surface that is densely covered. Unit: [N/m]. >= 0
};

/// Penetration depth of a tool, from the contacts at its pose alone:
///
///     g_i = sqrt(1 - K_i)           the factor by which both solids would have to be scaled to only touch: 1
///                                   at first touch, 0 where centres coincide
///     e_i = 1 - g_i                 for g_i >= g_0 = 1/2, and
///           1 - g_0 (3 + 6 v - v^2) / 8,    v = (g_i / g_0)^2,    below
///     L   = sqrt((q + s) / (r^T B^-2 r + s / a^2)),    q = r^T B^-1 r,    s = max(0, 1 - q)^3 / 10,
///                                   how far the part of the tool reaches along B^-1 r, which is the normal
///                                   of the plane that its contacts lie in; r = mean of d_i by alpha_i e_i^p
///     d_i = c_part - c_i            divided by (1 + (q_i - 1)^3)^(1/6) where q_i = d_i^T B^-1 d_i > 1
///     D   = c (sum alpha_i (e_i L_i)^(p+1)) / (sum alpha_i (e_i L_i)^p),    p = 3, c = (p + 2) / (p + 1)
///
/// with B the part's shape matrix and a its shortest semi-axis; L_i is that of the part of contact i; for a
/// ball it is the radius. The quotient is a mean dominated by the deepest contacts, so that D depends on the
/// position of the surface and not on its number of Gaussians. A Gaussian that enters or leaves the set has
/// e_i = 0 and no weight. If an ellipsoid is pressed into a plane of points, their e_i are uniformly
/// distributed from 0 to that of the deepest, depth / L: D is then the depth.
///
/// g_i is a norm of d_i whose unit ball is the Minkowski sum of the two solids, and 1 - g_i a cone: its
/// gradient jumps from one side of the tip to the other as the tool's centre passes the Gaussian's. The
/// quartic replaces the tip by a cap that meets the cone with two continuous derivatives; nothing changes
/// while all contacts are less than half as deep as possible. For the same reason s keeps L from rotating
/// with r where r is short, and d_i is shortened so that a large Gaussian whose centre is far outside the
/// tool does not decide where r points.
///
/// D has two continuous derivatives wherever it is positive, except where a Gaussian is infinitely thin or
/// the tool's centre is exactly at its centre: there the first is continuous.
struct FieldDepth {
  double depth = 0.0;                                  ///< D. Unit: [m].
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< dD / d(tool position), world frame
  /// dD / d(tool orientation): derivative by the rotation vector about the handle, world frame. Unit: [m].
  Eigen::Vector3d turning = Eigen::Vector3d::Zero();
};

/// \param contacts of `tool` at `pose`, X_WT, part by part as query() finds them
FieldDepth field_depth(const ContactSet& contacts, const Tool& tool, const Pose& pose);

/// Conservative force model: with U = k D^2 / 2, force = -dU/dx and torque = -dU/dtheta, exactly. The work
/// around a closed path is zero; the stiffness does not depend on how densely the scene was trained; there is
/// no state.
///
/// The force is continuous. Its change as the tool moves by dx, |dF| = m k |dx|:
///
///     ball of radius r, one point                     m <= (5/4)^2 (13/16) 3 = 3.8, derived: D D'' at the
///                                                     centre
///
///     Measured, not bounds:                            worst m seen, and what the tests allow
///     ball, one disc or needle of semi-axis s         4 to 200 for s / r from 1/4 to 10; 14 + 2 (s / r)^2
///     ball, random scenes of Gaussians up to 3 r      14; 16
///     ellipsoid 1:1:2, the same                       26; 32
///     five ellipsoids of up to 1:3, the same          75; 96
///
/// The last three are over 210 seeds. There is no bound for every scene: where a few Gaussians are deep and n
/// more begin to be touched elsewhere, a mean that does not depend on density falls from the depth of the few
/// to that of the many within about n^(-1/p) of the depth, and |dD/dx| is more than 1 there. See
/// docs/force-models.md.
///
/// Beyond the depth D_m = force_max / (c k), U goes on as k D_m (D - D_m / 2), and the force as k D_m
/// |dD/dx|: a force clamped by the device instead is not a gradient, and would supply energy to a hand that
/// slides under it and lifts off elsewhere. On a plane |dD/dx| is 1, for one Gaussian under a ball at most c,
/// so that the force is within ForceInput::force_max; where |dD/dx| is more than c, as above, it is not, and
/// is clamped.
///
/// The force points to the nearest way out, so that a tool pushed beyond the middle of a thin object is
/// expelled on the other side, as with any force that depends on the pose alone; the `proxy` model keeps
/// track of the side of entry.
class FieldForce final : public ForceModel {
 public:
  /// \pre contacts passed to evaluate() are those of `tool`, in double precision.
  explicit FieldForce(const Tool& tool, const FieldParameters& parameters = {})
      : tool_(tool), radius_(tool.radius()), parameters_(parameters) {}

  void reset() override {}
  ForceOutput evaluate(const ForceInput& input) override;

  /// U. Unit: [J].
  double potential(const ForceInput& input) const;

 private:
  double end_of_spring(const ForceInput& input) const;

  Tool tool_;
  double radius_;  ///< of the tool about its handle. Unit: [m].
  FieldParameters parameters_;
};

}  // namespace palpate

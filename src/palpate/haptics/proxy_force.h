/// \file
/// The constraint-based force: a proxy of the tool that stays on the surface.
#pragma once

#include <optional>

#include <palpate/collision/contact_tracker.h>
#include <palpate/collision/scene_index.h>
#include <palpate/haptics/constrained_motion.h>
#include <palpate/haptics/force_model.h>
#include <palpate/haptics/surface_fit.h>
#include <palpate/haptics/tool.h>

namespace palpate {

/// Parameters of ProxyForce.
struct ProxyParameters {
  double stiffness = 500.0;  ///< of the spring between tool and proxy. Unit: [N/m]. >= 0
  double friction = 0.0;     ///< Coulomb's coefficient. >= 0
  /// SurfaceKernel::detail; kDetailOfTool of the tool's thinnest semi-axis if unset. Unit: [m]. > 0
  std::optional<double> detail = {};

  /// A tool cannot tell much that is smaller than itself. This much of it keeps the direction of the force on
  /// splats a third of the tool's radius apart, displaced by a quarter of that, within four degrees, 95 times
  /// in 100.
  static constexpr double kDetailOfTool = 0.6;
};

/// A god-object (Zilles and Salisbury 1995), in six degrees of freedom (Ortega, Redon and Coquillart 2007),
/// on a surface that is made of the contacts themselves where the proxy is (Ryden and Chizeck 2013 do so on
/// points):
///
///  1. the contacts of the proxy, enlarged by SurfaceKernel::reach, make SurfacePatches;
///  2. the proxy moves towards the tool as far as the patches let it (constrained_motion()), at most half of
///  the
///     reach at once, so that nothing is passed unseen however fast the tool is; with friction, it stays
///     behind by no more than friction times what presses it on;
///  3. again, until it hardly moves, at most kMostSteps times, or kMostFreeSteps out of contact and at first,
///  where
///     the tool may begin inside something;
///  4. force = k (x_proxy - x_tool), torque = k g^2 (turn from tool to proxy), g the tool's radius of
///  gyration. Zero
///     where nothing holds the proxy back.
///
/// The proxy is on the side it came from, however thin the surface and however deep the push. What it did is
/// its memory: an object serves one tool on one thread. Takes nothing from the heap after construction,
/// unless there are more than kRoom contacts at once.
class ProxyForce final : public ForceModel {
 public:
  /// `index` must outlive it.
  ProxyForce(const SceneIndex& index, const Tool& tool, const ProxyParameters& parameters = {});

  void reset() override;
  ForceOutput evaluate(const ForceInput& input) override;

  std::span<const SurfacePatch> patches() const { return patches_.patches(); }

  static constexpr int kMostSteps = 4;       ///< in contact
  static constexpr int kMostFreeSteps = 32;  ///< out of contact, where a step costs little
  static constexpr std::size_t kRoom = 4096;

 private:
  /// Moves the proxy one step towards `target`. \returns how far. Unit: [m].
  double step(const Pose& target);
  Motion with_friction(const Motion& wanted, const Motion& free) const;

  Tool tool_;
  ProxyParameters parameters_;
  SurfaceKernel kernel_;
  double gyration_;  ///< Unit: [m].
  ContactTracker tracker_;
  ContactSet contacts_;
  SurfacePatches patches_;
  bool started_ = false;
  bool held_ = false;  ///< by a patch, in the last step
  Pose proxy_;         ///< world frame
};

}  // namespace palpate

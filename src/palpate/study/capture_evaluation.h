/// \file
/// Evaluation of force models on captured scenes against the visible surface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <palpate/base/progress.h>
#include <palpate/collision/scene_index.h>
#include <palpate/haptics/tool.h>
#include <palpate/scene/scene_filter.h>
#include <palpate/study/evaluation.h>
#include <palpate/study/seen_surface.h>
#include <palpate/study/spread.h>

namespace palpate {

/// A straight path to the seen surface, from outside the scene towards a Gaussian, from any side.
struct CaptureAim {
  Eigen::Vector3d from;   ///< start of the tool's handle, outside the scene. World frame. Unit: [m].
  Eigen::Vector3d along;  ///< unit
  double seen = 0.0;      ///< distance that the tool moves until it meets the seen surface. Unit: [m].
};

/// Draws `count` aims of a tool in the orientation of the world, at random Gaussians of `kept` along random
/// directions; fewer if hardly anything of the scene can be seen. \param rings see SeenRays.
std::vector<CaptureAim> capture_aims(const EllipsoidScene& kept, const SeenSurface& seen, const Tool& tool,
                                     std::size_t count, std::uint64_t seed, int rings = SeenRays::kRings,
                                     const Progress& progress = {});

/// One tick of a push or slide.
struct CaptureTick {
  Eigen::Vector3d tool, proxy;  ///< positions of the handle. World frame. Unit: [m].
  Eigen::Vector3d force;        ///< Unit: [N].
  /// Depth of the tool below the seen surface, along the aim; negative outside. Unit: [m].
  double depth = 0.0;
};

/// A push at 0.1 m/s, from a position without contact at least three tool radii above the seen surface, to
/// three tool radii below it, and back.
struct CapturePush {
  CaptureAim aim;
  /// Depth below the seen surface at which the force begins, on the way in; negative before it. Unit: [m].
  std::optional<double> onset;
  /// The same for the first Gaussian whose ellipsoid the tool overlaps.
  std::optional<double> touched;
  bool silent_5mm = false, silent_10mm = false;  ///< see CaptureFigures
  double untouched_force = 0.0;                  ///< largest force before an overlap. Unit: [N].
  /// Largest change of the force in a tick beyond stiffness times the tool's motion. Unit: [N].
  double step = 0.0;
  bool avoidable_5mm = false;  ///< see CaptureFigures
};

/// A slide at 0.1 m/s across the aim, at a constant depth of half the tool's shortest semi-axis below the
/// seen surface, for 100 mm or until the surface falls or rises by more than 45 degrees.
struct CaptureSlide {
  CaptureAim aim;
  double way = 0.0;  ///< Unit: [m].
  std::size_t ticks = 0;
  std::size_t strong = 0;  ///< ticks with a force above three times stiffness times depth
  std::size_t silent = 0;  ///< silent ticks, see CaptureFigures
  double step = 0.0;       ///< as CapturePush::step
  /// Silent ticks in which an ellipsoid is overlapped.
  std::size_t silent_touched = 0;
};

/// Statistics of pushes and slides. "Silent" is a force below a tenth of stiffness times depth. Shares of
/// pushes, or of ticks of slides; NaN if there are none.
struct CaptureFigures {
  std::size_t pushes = 0, slides = 0;
  double onset_within = 0.0;       ///< force begins within 5 mm of the seen surface
  double late = 0.0, early = 0.0;  ///< more than 5 mm behind it, or never; before it
  double silent_5mm = 0.0, silent_10mm = 0.0;
  /// Silent at a depth of 5 mm, although an ellipsoid is overlapped there and no rigid frictionless tool
  /// outside the seen surface is so near that its spring would be silent, too: a surface met with the flank
  /// lets the proxy slip to the side.
  double avoidable_5mm = 0.0;
  double untouched = 0.0;       ///< more than 1 N before an ellipsoid is overlapped
  double touched_within = 0.0;  ///< the first ellipsoid is overlapped within 5 mm of the seen surface
  Spread onset;                 ///< Unit: [m].
  double slide_strong = 0.0, slide_silent = 0.0;
  double slide_silent_touched = 0.0;  ///< silent, though an ellipsoid is overlapped
  Spread push_step, slide_step;       ///< Unit: [N].
  Spread tick;                        ///< time of contacts and force, in contact. Unit: [us].
};

class Hand;

/// Evaluation of one model on one scene. One thread.
class CaptureEvaluation {
 public:
  /// `index` and `seen` are of the same scene and must outlive it. \param stiffness nominal stiffness of the
  /// model, positive. Unit: [N/m].
  CaptureEvaluation(const SceneIndex& index, const SeenSurface& seen, const Tool& tool,
                    const ForceModelMaker& model, double stiffness, int rings = SeenRays::kRings);
  ~CaptureEvaluation();

  /// Runs a push or a slide; appends its ticks to `ticks` unless that is null.
  CapturePush push(const CaptureAim& aim, std::vector<CaptureTick>* ticks = nullptr);
  CaptureSlide slide(const CaptureAim& aim, std::vector<CaptureTick>* ticks = nullptr);

  /// Statistics of these, and of the time of all ticks so far.
  CaptureFigures figures(const std::vector<CapturePush>& pushes,
                         const std::vector<CaptureSlide>& slides) const;

 private:
  bool touches(const Eigen::Vector3d& position);
  /// Distance from the seen surface back to a position without contact. Unit: [m].
  double free_before(const CaptureAim& aim);
  /// True if a rigid frictionless tool that is pushed to `depth` slips off the seen surface before its spring
  /// is long enough to be felt.
  bool slips_off(const CaptureAim& aim, double depth) const;

  const SceneIndex& index_;
  const SeenSurface& seen_;
  Tool tool_;
  double stiffness_;
  int rings_;
  std::unique_ptr<Hand> hand_;
  ContactSet contacts_;
};

/// Similarity of the forces of two captures of one object at the same poses.
struct CaptureLikeness {
  Spread ratio;  ///< |F| of the second over the first, both felt and deeper than 5 mm
  /// Quantiles of that; NaN if there is none.
  double p10 = std::numeric_limits<double>::quiet_NaN(), p90 = std::numeric_limits<double>::quiet_NaN();
  double silent_in_one = 0.0;  ///< share of pushes that are silent 5 mm deep in exactly one of the two
};

/// Compares pushes along `aims`, which are of the first.
CaptureLikeness capture_likeness(CaptureEvaluation& first, CaptureEvaluation& second,
                                 const std::vector<CaptureAim>& aims);

}  // namespace palpate

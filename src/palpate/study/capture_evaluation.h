/// \file
/// Evaluation of force models on captured scenes against the visible surface.
#pragma once

#include <cstddef>
#include <cstdint>
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
  Eigen::Vector3d from;   ///< of the tool's handle, outside of the scene. World frame. Unit: [m].
  Eigen::Vector3d along;  ///< unit
  double seen = 0.0;      ///< how far the tool goes until it meets the seen surface. Unit: [m].
};

/// `count` aims of a tool that is oriented as the world, at Gaussians of `kept` that are drawn by lot, along
/// directions that are, too; fewer if nearly nothing of the scene can be seen. \param rings see SeenRays.
std::vector<CaptureAim> capture_aims(const EllipsoidScene& kept, const SeenSurface& seen, const Tool& tool,
                                     std::size_t count, std::uint64_t seed, int rings = SeenRays::kRings,
                                     const Progress& progress = {});

/// One tick of a push or slide.
struct CaptureTick {
  Eigen::Vector3d tool, proxy;  ///< positions of the handle. World frame. Unit: [m].
  Eigen::Vector3d force;        ///< Unit: [N].
  /// How deep the tool is below the seen surface, along the aim; negative outside. Unit: [m].
  double depth = 0.0;
};

/// A push at 0.1 m/s, from where nothing is touched, three of the tool's radii at least above the seen
/// surface, to as many below it, and back.
struct CapturePush {
  CaptureAim aim;
  /// Where the force begins, on the way in, from the seen surface; negative before it. Unit: [m].
  std::optional<double> onset;
  /// The same of the first Gaussian whose ellipsoid the tool overlaps.
  std::optional<double> touched;
  bool silent_5mm = false, silent_10mm = false;  ///< see CaptureFigures
  double untouched_force = 0.0;                  ///< largest, before an ellipsoid is overlapped. Unit: [N].
  /// Largest change of the force in a tick beyond stiffness times the tool's motion. Unit: [N].
  double step = 0.0;
  bool avoidable_5mm = false;  ///< see CaptureFigures
};

/// A slide at 0.1 m/s across the aim, half of the tool's thinnest semi-axis below the seen surface all the
/// way, for 100 mm or to where that turns by more than 45 degrees out of the slide's plane.
struct CaptureSlide {
  CaptureAim aim;
  double way = 0.0;  ///< Unit: [m].
  std::size_t ticks = 0;
  std::size_t strong = 0;  ///< of them, with more than three times stiffness times depth
  std::size_t silent = 0;  ///< of them, see CaptureFigures
  double step = 0.0;       ///< as CapturePush::step
  /// Of the silent ticks, those in which an ellipsoid is overlapped.
  std::size_t silent_touched = 0;
};

/// What many of both come to. "Silent" is a force below a tenth of stiffness times depth. Shares of pushes,
/// or of ticks of slides; NaN of none.
struct CaptureFigures {
  std::size_t pushes = 0, slides = 0;
  double onset_within = 0.0;       ///< force begins within 5 mm of the seen surface
  double late = 0.0, early = 0.0;  ///< more than 5 mm behind it, or never; before it
  double silent_5mm = 0.0, silent_10mm = 0.0;
  /// Silent 5 mm deep, though an ellipsoid has been overlapped by then, and though no rigid tool, without
  /// friction and outside of all that is seen, is so near that its spring would be silent, too: what is met
  /// with the flank gives way to the side.
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
  /// `index` and `seen` are of the same scene and must outlive it. \param stiffness that the model promises;
  /// > 0. Unit: [N/m].
  CaptureEvaluation(const SceneIndex& index, const SeenSurface& seen, const Tool& tool,
                    const ForceModelMaker& model, double stiffness, int rings = SeenRays::kRings);
  ~CaptureEvaluation();

  /// What was felt in every tick is added to `ticks` where that is given.
  CapturePush push(const CaptureAim& aim, std::vector<CaptureTick>* ticks = nullptr);
  CaptureSlide slide(const CaptureAim& aim, std::vector<CaptureTick>* ticks = nullptr);

  /// Of these, and of the time of all ticks so far.
  CaptureFigures figures(const std::vector<CapturePush>& pushes,
                         const std::vector<CaptureSlide>& slides) const;

 private:
  bool touches(const Eigen::Vector3d& position);
  /// From the seen surface back, the way to where nothing is touched.
  double free_before(const CaptureAim& aim);
  /// True if a rigid tool without friction that is pushed to `depth` slips off what is seen before its spring
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
  Spread ratio;                 ///< of |F|, the second's over the first's, where both are felt and 5 mm deep
  double p10 = 0.0, p90 = 0.0;  ///< of that
  double silent_in_one = 0.0;   ///< share of pushes that are silent 5 mm deep in one of both alone
};

/// Of pushes along `aims`, which are of the first.
CaptureLikeness capture_likeness(CaptureEvaluation& first, CaptureEvaluation& second,
                                 const std::vector<CaptureAim>& aims);

}  // namespace palpate

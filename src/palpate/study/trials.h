/// \file
/// Force model trials with any tool at any place and speed on known solids.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <palpate/base/progress.h>
#include <palpate/haptics/tool.h>
#include <palpate/study/capture_defects.h>
#include <palpate/study/evaluation.h>
#include <palpate/study/spread.h>

namespace palpate {

/// Returns the names of the places that trials push at, on solids and sheets sized for the tool:
///   face     of a box, within 20 degrees of its normal
///   edge     of a box, aimed within 3 mm and 45 degrees of its outward bisector
///   corner   the same
///   hole     the rim of a ring's hole, alternately a bit wider and a bit narrower than the tool
///   plate    a plate of one or two of the tool's thinnest semi-axes
///   sheet    of no thickness
///   inside   a face, in which the tool starts 0.2 to 0.9 of its thinnest semi-axis deep
std::span<const std::string_view> trial_places();

/// One row of trials. Gaussians are a third of the tool's thinnest semi-axis apart, 0.5 to 6 mm, displaced by
/// a quarter of that and tilted by 10 degrees (standard deviations).
struct TrialSetup {
  std::string place;            ///< of trial_places()
  Tool tool;                    ///< in a random orientation
  bool tip_first = false;       ///< pushed along its z axis instead, within 10 degrees
  CaptureDefects defects = {};  ///< of the scenes
  ForceModelMaker model;
  double stiffness = 0.0;     ///< nominal, of the model; > 0. Unit: [N/m].
  std::size_t strokes = 100;  ///< > 0
  std::uint64_t seed = 1;     ///< of the two scenes between which strokes alternate, and of the strokes
};

/// One tick of a stroke. World frame.
struct TrialTick {
  Eigen::Vector3d tool, proxy;  ///< positions of the handle. Unit: [m].
  Eigen::Vector3d force;        ///< Unit: [N].
  double depth = 0.0;  ///< of the deepest point of the tool in the true solid, or below the near side of
                       ///< a plate or sheet; negative outside. Unit: [m].
  double proxy_depth = 0.0;  ///< the same of the proxy
  double confidence = 1.0;   ///< see ForceOutput
};

/// A straight way in, three of the tool's shortest semi-axes or 60 mm deep (30 mm long if it starts inside),
/// a rest of 10 ms, the way back and another rest, at 0.05 to 50 m/s, log-uniformly distributed.
struct TrialStroke {
  std::size_t number = 0;
  double speed = 0.0;  ///< Unit: [m/s].
  /// Distances from the start at which the tool meets the true surface, meets the seen one (SeenRays), first
  /// overlaps the ellipsoid of a Gaussian, and at which the force begins, on slow strokes from outside; the
  /// last to within half the motion of a tick. Unit: [m].
  std::optional<double> met, seen, touched, felt;
  bool silent = false;  ///< see TrialFigures
  bool sunk = false, through = false, stuck = false;
  double step = 0.0;              ///< as TrialFigures::step
  std::vector<double> magnitude;  ///< as TrialFigures::magnitude

  bool slow() const;
  /// Delay of the force behind the first position where it could begin: the seen surface, or the first
  /// ellipsoid if that comes later. Negative: before it. Nothing if not measured, or without a force. Unit:
  /// [m].
  std::optional<double> late() const;
};

/// Statistics of strokes. Shares are NaN if there are none.
struct TrialFigures {
  std::size_t strokes = 0, slow = 0;  ///< slow: up to 0.5 m/s
  /// Slow strokes from outside that meet the seen surface:
  std::size_t onsets = 0;
  Spread onset;        ///< force onset relative to the seen surface; negative before it. Unit: [m].
  Spread onset_depth;  ///< the same from the true surface
  Spread late;         ///< TrialStroke::late(). Unit: [m].
  double within_half_mm = 0.0, within_1mm = 0.0;  ///< shares with a force and |late| up to that
  /// Slow strokes at flat places on the way in, where deeper than the smaller of 4 mm and the tool's shortest
  /// semi-axis: |F| over stiffness times the depth below the seen surface, of the tool in the orientation of
  /// the proxy: an end that yields by rotation is not as deep.
  Spread magnitude;
  /// Strokes with a force below a tenth of stiffness times the depth of the tool's deepest point, more than 5
  /// ms after that depth exceeds the larger of 5 mm and half the shortest semi-axis (or all of that, for a
  /// tool of up to 5 mm); for fast strokes, at the end of the rest. The depth is the shortest way out, of a
  /// plate or sheet that to the side it came from, minus the noise.
  std::size_t silent = 0;
  /// Strokes in which the proxy gets deeper than half the shortest semi-axis into the solid (below the start,
  /// if that is inside), and those in which it comes out on the other side of a plate or sheet. A start
  /// inside is not judged for the first 8 ticks, in which the proxy may come out on the inner side: the
  /// stroke is through if the proxy returns later.
  std::size_t sunk = 0, through = 0;
  /// Strokes from outside at flat places that end with a force at their start, where nothing is touched. At
  /// an edge or rim a proxy may rightly stay behind.
  std::size_t stuck = 0;
  Spread step;  ///< of slow strokes, the largest change of the force in a tick beyond stiffness times the
                ///< tool's motion. Unit: [N].
  Spread tick;  ///< time of contacts and force, in contact. Unit: [us].
  /// Numbers of the failed strokes; for `late`, those by more than 1 mm or without a force.
  std::vector<std::size_t> silent_strokes, sunk_strokes, through_strokes, stuck_strokes, late_strokes;
};

/// Runs all strokes of a row. Single-threaded; deterministic except for TrialFigures::tick.
TrialFigures run_trials(const TrialSetup& setup, const Progress& progress = {});

/// Repeats stroke `number` of a row alone, with identical results; stores its ticks in `ticks` if not null.
TrialStroke repeat_trial(const TrialSetup& setup, std::size_t number,
                         std::vector<TrialTick>* ticks = nullptr);

}  // namespace palpate

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
///   hole     the rim of a ring's hole, every other a bit wider than the tool, or narrower
///   plate    a plate of one or two of the tool's thinnest semi-axes
///   sheet    of no thickness
///   inside   a face, where the tool starts between 0.2 and 0.9 of its thinnest semi-axis deep in it
std::span<const std::string_view> trial_places();

/// One row of trials. Gaussians are a third of the tool's thinnest semi-axis apart, 0.5 to 6 mm, displaced by
/// a quarter of that and tilted by 10 degrees (standard deviations).
struct TrialSetup {
  std::string place;            ///< of trial_places()
  Tool tool;                    ///< held at random
  bool tip_first = false;       ///< pushed along its z axis instead, within 10 degrees
  CaptureDefects defects = {};  ///< of the scenes
  ForceModelMaker model;
  double stiffness = 0.0;     ///< that the model promises; > 0. Unit: [N/m].
  std::size_t strokes = 100;  ///< > 0
  std::uint64_t seed = 1;     ///< of the two scenes that strokes take turns in, and of the strokes
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

/// A way straight in, three of the tool's thinnest semi-axes or 60 mm deep (30 mm from where it starts
/// inside), a rest of 10 ms, the way back and another rest, at 0.05 to 50 m/s, all orders of magnitude alike.
struct TrialStroke {
  std::size_t number = 0;
  double speed = 0.0;  ///< Unit: [m/s].
  /// Where on the way the tool meets the true surface, where the seen one (SeenRays), where it first overlaps
  /// the ellipsoid of a Gaussian and where the force begins, on slow strokes from outside; of the last to
  /// half a tick's way. Unit: [m].
  std::optional<double> met, seen, touched, felt;
  bool silent = false;  ///< see TrialFigures
  bool sunk = false, through = false, stuck = false;
  double step = 0.0;              ///< as TrialFigures::step
  std::vector<double> magnitude;  ///< as TrialFigures::magnitude

  bool slow() const;
  /// The force begins so much behind where it can: the seen surface, or the first ellipsoid where that comes
  /// later. Negative: before it. Nothing if not measured, or if it never begins. Unit: [m].
  std::optional<double> late() const;
};

/// Statistics of strokes. Shares are NaN if there are none.
struct TrialFigures {
  std::size_t strokes = 0, slow = 0;  ///< slow: up to 0.5 m/s
  /// Of slow strokes from outside that meet the seen surface:
  std::size_t onsets = 0;
  Spread onset;        ///< where the force begins, from the seen surface; negative before it. Unit: [m].
  Spread onset_depth;  ///< the same from the true surface
  Spread late;         ///< TrialStroke::late(). Unit: [m].
  double within_half_mm = 0.0, within_1mm = 0.0;  ///< shares whose `late` is as small; never felt is not
  /// Of slow strokes at flat places on the way in, where deeper than 4 mm or the tool's thinnest semi-axis:
  /// |F| over stiffness times the depth below the seen surface of the tool turned as the proxy is: an end
  /// that gives way by turning is not as deep.
  Spread magnitude;
  /// Strokes in which the force stays below a tenth of the stiffness times how deep the deepest point of the
  /// tool is, 5 ms after that is more than the larger of 5 mm and half of the thinnest semi-axis (or all of
  /// that, of a tool of up to 5 mm); of fast ones, when the hand has rested. That depth is the nearest way
  /// out, of a plate or sheet that to the side it came from, less the noise.
  std::size_t silent = 0;
  /// Strokes in which the proxy gets deeper than half the thinnest semi-axis into the solid (where the tool
  /// starts inside: deeper than it started), and those in which it comes out on the other side of a plate or
  /// sheet. A start inside is not judged for the first 8 ticks, in which the proxy may come out on the inner
  /// side: it is through if it comes back later.
  std::size_t sunk = 0, through = 0;
  /// Strokes from outside at flat places at whose end, where they began and nothing is touched, a force is
  /// left. Around an edge or rim a proxy may rightly stay behind.
  std::size_t stuck = 0;
  Spread step;  ///< of slow strokes, the largest change of the force in a tick beyond stiffness times the
                ///< tool's motion. Unit: [N].
  Spread tick;  ///< time of contacts and force, in contact. Unit: [us].
  /// Numbers of the strokes that failed; of `late` those by more than 1 mm, or never felt.
  std::vector<std::size_t> silent_strokes, sunk_strokes, through_strokes, stuck_strokes, late_strokes;
};

/// Runs all strokes of a row. Single-threaded; deterministic except for TrialFigures::tick.
TrialFigures run_trials(const TrialSetup& setup, const Progress& progress = {});

/// Repeats stroke `number` of a row alone, with identical results; stores its ticks in `ticks` if not null.
TrialStroke repeat_trial(const TrialSetup& setup, std::size_t number,
                         std::vector<TrialTick>* ticks = nullptr);

}  // namespace palpate

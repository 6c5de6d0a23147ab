/// \file
/// Scenes of known surfaces with the defects of real captures.
#pragma once

#include <span>
#include <string_view>

#include <palpate/scene/gaussian_scene.h>
#include <palpate/study/procedural.h>

namespace palpate {

/// Defects of a capture. h is the spacing of its Gaussians; sizes are standard deviations.
struct CaptureDefects {
  /// Extents in the surface vary by a log-normal factor (standard deviation 0.7 of ln); in addition, one
  /// Gaussian in 100 is five times as large, and one in 50 a needle of 10:1.
  bool tails = false;
  /// Additional Gaussians, 2 % of all, anywhere in the air within 0.1 m of the surface: of 0.3 to 3 h and
  /// opacity 0.05 to 0.4.
  bool floaters = false;
  /// A second sheet, as dense and half as opaque, 2 to 4 mm behind or in front of the first, smoothly
  /// varying.
  bool double_layers = false;
  /// A cloud of Gaussians of 5 to 30 mm and opacity 0.02 to 0.12 in the air within 0.1 m of the surface,
  /// dense enough to absorb a fifth of the light over 50 mm.
  bool haze = false;
  /// No Gaussians on a tenth of the surface, in discs of radius h to 2 h.
  bool holes = false;
  /// The spacing varies smoothly over the surface, from h to 10 h, and with it the sizes.
  bool density = false;
  /// Additional Gaussians, three for every two others, within 20 mm of the surface, of 0.5 to 2 h and opacity
  /// 0.005 to 0.1: remnants of training, for which opacity filters exist.
  bool faint = false;
};

/// The names of the single defects: tails, floaters, double, haze, holes, density, faint.
std::span<const std::string_view> capture_defects();

/// Sets the defect of that name. \throws Error if it is not among capture_defects().
void set_defect(CaptureDefects& defects, std::string_view name);

/// make_scene() with defects; without any, the same scene. As deterministic as that. Ids are 0, 1, ...
/// \throws Error as make_scene().
GaussianScene make_capture(const AnalyticSurface& surface, const ProceduralOptions& options,
                           const CaptureDefects& defects);

}  // namespace palpate

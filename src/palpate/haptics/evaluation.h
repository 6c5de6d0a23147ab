/// \file
/// Force models against surfaces that are known exactly: how true is what the hand feels?
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <palpate/base/progress.h>
#include <palpate/collision/scene_index.h>
#include <palpate/haptics/force_model.h>
#include <palpate/haptics/tool.h>
#include <palpate/scene/procedural.h>

namespace palpate {

/// A model that feels the scene of an index; the index outlives it.
using ForceModelMaker = std::function<std::unique_ptr<ForceModel>(const SceneIndex&)>;

/// What is felt, with what, and how much of it.
struct EvaluationSetup {
  std::string shape;                           ///< of procedural_shapes()
  ProceduralOptions scene;                     ///< its noise is what the model has to cope with
  Tool tool{Eigen::Vector3d::Constant(0.02)};  ///< one ellipsoid
  ForceModelMaker model;
  double stiffness = 0.0;    ///< that the model promises; 0 if none. Unit: [N/m].
  std::size_t scenes = 1;    ///< that are made of the shape, with one seed after the other; > 0
  std::size_t places = 100;  ///< where the surface is pressed, slid along and pushed through, in all; > 0
  std::uint64_t seed = 1;    ///< of the places
};

/// Quantiles; NaN if there was nothing to take them of.
struct Spread {
  double p05, p50, p95, p99, max;
};

/// What was measured, at a tick of 1 ms. Places are those of the surface where it is smooth for a tool's
/// radius around and the tool fits.
struct Evaluation {
  /// Of presses straight in at 0.1 m/s, from outside to 1.5 tool radii, where they are deeper than 4 mm:
  Spread direction;         ///< angle of the force from the true normal. Unit: [deg].
  Spread magnitude;         ///< |F| / (stiffness depth); NaN if no stiffness was promised
  std::size_t silent = 0;   ///< ticks without force
  std::size_t flipped = 0;  ///< ticks with a force that pulls in
  Spread onset;             ///< how deep the first force is felt; negative: above the surface. Unit: [m].

  /// Of slides at 0.1 m/s over 30 mm, half a tool radius deep:
  Spread ripple;  ///< standard deviation of |F| over its mean, a slide
  Spread jump;    ///< largest change of the force from tick to tick, a slide. Unit: [N].

  /// Of pushes aslant by up to 30 degrees, to three tool radii beyond the surface, at 0.1 to 1 m/s and every
  /// tenth at 2 m/s: those that came out on the other side. A model with a proxy does if that gets inside or
  /// behind, another if its force pulls along.
  std::size_t pushes = 0, through = 0;

  /// Of circles of a quarter of the tool's radius in the surface, as deep as that: |work done on the hand
  /// around| over the largest (stiffness depth^2 / 2); NaN if no stiffness was promised.
  Spread loop;

  Spread tick;  ///< time of contacts and force, in contact. Unit: [us].
};

/// One thread; the same answers every time but for Evaluation::tick.
/// \throws Error if the shape is unknown or has no place that is smooth enough.
Evaluation evaluate(const EvaluationSetup& setup, const Progress& progress = {});

/// How a step of known height is felt across.
struct StepResponse {
  double height;     ///< true. Unit: [m].
  Spread felt;       ///< the largest rise of the proxy within `travel`, a crossing. Unit: [m].
  double travel;     ///< Unit: [m].
  Spread rise_over;  ///< way in which it goes from a tenth to nine tenths of what it rises in all. Unit: [m].
};

/// The sheet `step` of make_surface(), crossed at 0.1 m/s by a ball.
StepResponse step_response(const ForceModelMaker& model, const Tool& tool, const ProceduralOptions& scene,
                           std::size_t crossings, std::uint64_t seed);

}  // namespace palpate

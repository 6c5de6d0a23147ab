/// \file
/// Evaluation of force models against exactly known surfaces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <palpate/base/progress.h>
#include <palpate/collision/scene_index.h>
#include <palpate/haptics/force_model.h>
#include <palpate/haptics/tool.h>
#include <palpate/study/procedural.h>
#include <palpate/study/spread.h>

namespace palpate {

/// Creates a force model for a tool on the scene of an index, which outlives it. `friction` applies if the
/// model supports friction.
using ForceModelMaker =
    std::function<std::unique_ptr<ForceModel>(const SceneIndex&, const Tool&, double friction)>;

/// Parameters of an evaluation.
struct EvaluationSetup {
  std::string shape;                           ///< of procedural_shapes()
  ProceduralOptions scene;                     ///< its noise disturbs the model
  Tool tool{Eigen::Vector3d::Constant(0.02)};  ///< one ellipsoid
  ForceModelMaker model;
  double stiffness = 0.0;    ///< that the model promises; 0 if none. Unit: [N/m].
  double friction = 0.0;     ///< Coulomb's coefficient where friction is measured; 0 if the model has none
  std::size_t scenes = 1;    ///< that are made of the shape, with one seed after the other; > 0
  std::size_t places = 100;  ///< where the surface is pressed and slid along, in all; > 0
  std::size_t pushes = 100;  ///< to the other side of the surface, in all
  std::uint64_t seed = 1;    ///< of the places
};

/// What was measured, at a tick of 1 ms and without friction unless it says otherwise. Places are those of
/// the surface where it is smooth for a tool's radius around and the tool fits; how deep the tool is in the
/// surface is told by its point that is first to touch.
struct Evaluation {
  /// Of presses straight in at 0.1 m/s, from outside to 1.5 tool radii, where they are deeper than 4 mm:
  Spread direction;       ///< angle of the force from the true normal. Unit: [deg].
  Spread magnitude;       ///< |F| / (stiffness depth); NaN if no stiffness was promised
  Spread magnitude_seen;  ///< the same, of the depth below where the tool first meets the seen surface
                          ///< (SeenSurface)
  Spread seen;  ///< how deep the tool is where it does; negative: above the true surface. Unit: [m].
  std::size_t silent = 0;   ///< ticks without force
  std::size_t flipped = 0;  ///< ticks with a force that pulls in
  Spread onset;             ///< how deep the first force is felt; negative: above the surface. Unit: [m].
  /// Over depth [m], from 0:
  Curve direction_at;  ///< where there is a force. Unit: [deg].
  Curve force_at;      ///< |F|. Unit: [N].

  /// Of slides at 0.1 m/s over 30 mm, half a tool radius deep:
  Spread ripple;                       ///< standard deviation of |F| over its mean, a slide
  Spread jump;                         ///< largest change of the force from tick to tick, a slide. Unit: [N].
  std::vector<Eigen::Vector2d> slide;  ///< the first of them: way [m] and |F| [N]
  double slide_depth = 0.0;            ///< of that one. Unit: [m].

  /// |F| at each place with the tool at rest, half a tool radius deep: the same poses for every scene of a
  /// shape and every model. Unit: [N].
  std::vector<double> held;

  /// Pushes tilted by up to 30 degrees, to three tool radii beyond the surface, at 0.1 to 1 m/s and every
  /// tenth at 2 m/s, and the number of them that pass through. A model with a proxy passes through if the
  /// proxy gets inside or behind; another if its force pulls along, or is zero behind the surface. On a
  /// sheet, pushes keep so far from its border that the shortest way out is never around it.
  std::size_t pushes = 0, through = 0;
  std::size_t fast = 0, fast_through = 0;  ///< of them at 2 m/s

  /// Of circles of a quarter of the tool's radius in the surface, as deep as that: |work done on the hand
  /// around| over the largest (stiffness depth^2 / 2); NaN if no stiffness was promised.
  Spread loop;

  /// With EvaluationSetup::friction; NaN without:
  Spread friction;  ///< of slides as above, drag along over force against the true normal, means of a slide
  Spread creep;  ///< how far the proxy goes in 10 s where the tool, aside by half of what would make it slip,
                 ///< rests. Unit: [m].

  Spread tick;  ///< time of contacts and force, in contact. Unit: [us].
};

/// Single-threaded; deterministic except for Evaluation::tick.
/// \throws Error if the shape is unknown or has no place that is smooth enough.
Evaluation evaluate(const EvaluationSetup& setup, const Progress& progress = {});

/// Returns |F| on one scene over |F| on another at the same poses, where both are nonzero. \pre both are of
/// the same shape, tool, places and seed.
Spread force_ratio(const Evaluation& one, const Evaluation& other);

/// Returns the friction measured as for Evaluation::friction over each commanded coefficient of
/// `coefficients`; in one scene, at ten places.
Curve friction_response(const EvaluationSetup& setup, const std::vector<double>& coefficients);

}  // namespace palpate

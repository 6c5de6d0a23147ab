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
  ProceduralOptions scene;                     ///< options of the scene; its noise disturbs the model
  Tool tool{Eigen::Vector3d::Constant(0.02)};  ///< one ellipsoid
  ForceModelMaker model;
  double stiffness = 0.0;    ///< nominal, of the model; 0 if it has none. Unit: [N/m].
  double friction = 0.0;     ///< nominal coefficient where friction is measured; 0 if the model has none
  std::size_t scenes = 1;    ///< number of scenes of the shape, with consecutive seeds; > 0
  std::size_t places = 100;  ///< number of places to press and slide at, in all scenes; > 0
  std::size_t pushes = 100;  ///< number of pushes to the other side of the surface, in all scenes
  std::uint64_t seed = 1;    ///< of the choice of places
};

/// Results, for ticks of 1 ms and without friction unless stated. Places are points of the surface where it
/// is smooth within 1.5 tool radii and the tool fits; depth is that of the tool's point that touches first.
struct Evaluation {
  /// Straight presses at 0.1 m/s, from outside to a depth of 1.5 tool radii, where deeper than 4 mm:
  Spread direction;        ///< angle of the force from the true normal. Unit: [deg].
  Spread magnitude;        ///< |F| / (stiffness depth); NaN without a nominal stiffness
  Spread magnitude_seen;   ///< the same, by the depth below first contact with the seen surface (SeenSurface)
  Spread seen;             ///< depth of that contact; negative: above the true surface. Unit: [m].
  std::size_t silent = 0;  ///< ticks without force
  std::size_t flipped = 0;  ///< ticks with a force that pulls in
  Spread onset;             ///< depth of the first force; negative: above the surface. Unit: [m].
  /// Over depth [m], from 0:
  Curve direction_at;  ///< where there is a force. Unit: [deg].
  Curve force_at;      ///< |F|. Unit: [N].

  /// Slides at 0.1 m/s over 30 mm, at a depth of half a tool radius:
  Spread ripple;                       ///< standard deviation of |F| over its mean, per slide
  Spread jump;                         ///< largest change of the force in a tick, per slide. Unit: [N].
  std::vector<Eigen::Vector2d> slide;  ///< the first of them: distance [m] and |F| [N]
  double slide_depth = 0.0;            ///< of the first. Unit: [m].

  /// |F| at each place with the tool at rest, at a depth of half a tool radius: the same poses for every
  /// scene of a shape and every model. Unit: [N].
  std::vector<double> held;

  /// Pushes tilted by up to 30 degrees, to three tool radii beyond the surface, at 0.1 to 1 m/s and every
  /// tenth at 2 m/s, and the number of them that pass through. A model with a proxy passes through if the
  /// proxy gets inside or behind; another if its force pulls along, or is zero behind the surface. On a
  /// sheet, pushes stay so far from its border that the shortest way out is never around it.
  std::size_t pushes = 0, through = 0;
  std::size_t fast = 0, fast_through = 0;  ///< those at 2 m/s

  /// Circles of a quarter of the tool's radius parallel to the surface, at a depth of the same: |work done on
  /// the hand in a turn| over the energy of the spring (stiffness depth^2 / 2); NaN without a nominal
  /// stiffness.
  Spread loop;

  /// With EvaluationSetup::friction; NaN without it:
  Spread friction;  ///< drag over force along the true normal, means of a slide, as above
  Spread creep;  ///< displacement of the proxy in 10 s while the tool rests, displaced by half of what would
                 ///< make it slip. Unit: [m].

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

/// \file
/// Response of force models to a step of known height and to an edge, crossed by a ball.
#pragma once

#include <palpate/study/evaluation.h>

namespace palpate {

/// Proxy motion across a step of known height. NaN for a model without a proxy.
struct StepResponse {
  static constexpr double kBall = 0.005;    ///< radius of the ball. Unit: [m].
  static constexpr double kHeight = 0.003;  ///< of the true step. Unit: [m].
  static constexpr double kTravel = 0.015;  ///< Unit: [m].
  Spread felt;       ///< largest rise of the proxy within kTravel, per crossing. Unit: [m].
  Spread rise_over;  ///< distance over which it rises from 10 % to 90 % of its total rise. Unit: [m].
  Curve path;        ///< height of the proxy's centre above the lower plane over position. Unit: [m].
};

/// Measures crossings of the surface `step` of make_surface() at 0.1 m/s by a ball whose centre is in the
/// lower plane. EvaluationSetup::places is the number of crossings; its shape and tool are ignored.
StepResponse step_response(const EvaluationSetup& setup);

/// Height of the centre of a ball of StepResponse::kBall that rolls over that step, at the distance `way`
/// from it. Unit: [m].
double step_truth(double way);

/// Proxy motion across a convex edge of 90 degrees. NaN for a model without a proxy.
struct EdgeResponse {
  Spread off;    ///< largest distance of the proxy from the path of a rolling ball, per crossing. Unit: [m].
  double where;  ///< of the largest of all: position along the path of the rolling ball's centre, from the
                 ///< middle of its turn about the edge. Unit: [m].
  Curve error;   ///< distance of proxy and surface minus the radius, over that position. Unit: [m].
};

/// Measures crossings of an edge of the surface `box` of make_surface() at 0.1 m/s by a ball whose radius is
/// the tool's shortest semi-axis, at a constant depth of half that. EvaluationSetup::places is the number of
/// crossings.
EdgeResponse edge_response(const EvaluationSetup& setup);

}  // namespace palpate

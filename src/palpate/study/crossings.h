/// \file
/// Response of force models to a step of known height and to an edge, crossed by a ball.
#pragma once

#include <palpate/study/evaluation.h>

namespace palpate {

/// Proxy motion across a step of known height. NaN for a model without a proxy.
struct StepResponse {
  static constexpr double kBall = 0.005;    ///< radius of what crosses it. Unit: [m].
  static constexpr double kHeight = 0.003;  ///< true. Unit: [m].
  static constexpr double kTravel = 0.015;  ///< Unit: [m].
  Spread felt;       ///< the largest rise of the proxy within kTravel, a crossing. Unit: [m].
  Spread rise_over;  ///< way in which it goes from a tenth to nine tenths of what it rises in all. Unit: [m].
  Curve path;        ///< centre of the proxy: height over the lower plane over way from the step. Unit: [m].
};

/// The surface `step` of make_surface(), crossed at 0.1 m/s by a ball whose centre is in the lower plane.
/// EvaluationSetup::places are the crossings; its shape and tool are not asked for.
StepResponse step_response(const EvaluationSetup& setup);

/// Height of the centre of a ball of StepResponse::kBall that rolls over that step, `way` from it. Unit: [m].
double step_truth(double way);

/// Proxy motion across a convex edge of 90 degrees. NaN for a model without a proxy.
struct EdgeResponse {
  Spread off;    ///< largest distance of the proxy from where a ball rolls, a crossing. Unit: [m].
  double where;  ///< of the largest of all: way along where the ball's centre rolls, from the middle of its
                 ///< turn about the edge. Unit: [m].
  Curve error;   ///< distance of proxy and surface less the radius, over that way. Unit: [m].
};

/// An edge of the surface `box` of make_surface(), crossed at 0.1 m/s by a ball as thick as the tool is where
/// it is thinnest, half its radius deep all the way. EvaluationSetup::places are the crossings.
EdgeResponse edge_response(const EvaluationSetup& setup);

}  // namespace palpate

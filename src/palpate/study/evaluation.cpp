#include <palpate/study/evaluation.h>

#include <algorithm>

#include <palpate/base/error.h>
#include <palpate/study/evaluation_strokes.h>

namespace palpate {
namespace {

/// Samples the surface for places where it is smooth enough. \throws Error if there are none.
std::vector<SurfaceSample> smooth_places(const AnalyticSurface& surface, const Tool& tool, Random& random) {
  constexpr double kSpacing = 0.01;
  const double radius = tool.radius();
  std::vector<SurfaceSample> smooth;
  for (const auto& [place, part] : surface.samples(kSpacing, random)) {
    if (tool_fits(surface, place, tool) && is_smooth(surface, place, 1.5 * radius)) smooth.push_back(place);
  }
  if (smooth.empty())
    throw Error("{}: no place is smooth enough for a tool of {} mm", surface.name(), 1e3 * radius);
  return smooth;
}

std::vector<SurfaceSample> choose(const std::vector<SurfaceSample>& places, std::size_t count,
                                  Random& random) {
  std::vector<SurfaceSample> chosen;
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(places[random.index(places.size())]);
  return chosen;
}

/// All measurements on one surface.
class Measurements {
 public:
  Measurements(const AnalyticSurface& surface, const EvaluationSetup& setup)
      : setup_(setup),
        random_(setup.seed),
        smooth_(smooth_places(surface, setup.tool, random_)),
        places_(choose(smooth_, setup.places, random_)),
        presses_(setup),
        slides_(surface),
        loops_(setup.stiffness),
        pushes_(surface, setup.seed + 1),
        rubs_(surface, setup.friction) {}

  /// Runs the measurements in scene `k`; calls `done()` after each of its places and pushes.
  template <class Done>
  void in_scene(const SceneIndex& index, const SeenSurface& seen, std::size_t k, const Done& done) {
    Hand hand(index, setup_.tool, setup_.model);
    Hand rubbing(index, setup_.tool, setup_.model, setup_.friction);
    for (std::size_t i = k; i < places_.size(); i += setup_.scenes, done()) {
      presses_.at(hand, places_[i], seen);
      slides_.at(hand, places_[i]);
      loops_.at(hand, places_[i]);
      if (setup_.friction > 0.0) rubs_.at(rubbing, places_[i]);
    }
    for (std::size_t i = k; i < setup_.pushes; i += setup_.scenes, done()) pushes_.somewhere(hand, smooth_);
    ticks_.insert(ticks_.end(), hand.ticks().begin(), hand.ticks().end());
  }

  /// Total number of calls of `done`.
  std::size_t work() const { return places_.size() + setup_.pushes; }

  Evaluation result() const {
    Evaluation result{};
    presses_.tell(result);
    slides_.tell(result);
    loops_.tell(result);
    pushes_.tell(result);
    rubs_.tell(result);
    result.tick = spread_of(ticks_);
    return result;
  }

 private:
  const EvaluationSetup& setup_;
  Random random_;
  std::vector<SurfaceSample> smooth_;
  std::vector<SurfaceSample> places_;  ///< chosen from smooth_, the same ones for every scene of the surface
  Presses presses_;
  Slides slides_;
  Loops loops_;
  Pushes pushes_;
  Rubs rubs_;
  std::vector<double> ticks_;
};

}  // namespace

Evaluation evaluate(const EvaluationSetup& setup, const Progress& progress) {
  const auto surface = make_surface(setup.shape);
  Measurements measurements(*surface, setup);
  std::size_t done = 0;
  for (std::size_t k = 0; k < setup.scenes; ++k) {
    const GaussianScene scene = gaussians_of(*surface, setup, k);
    const SceneIndex index(scene, SceneFilter{}, Similarity{});
    measurements.in_scene(index, SeenSurface(scene, Similarity{}), k, [&] {
      report(progress, "evaluating", static_cast<double>(++done) / static_cast<double>(measurements.work()));
    });
  }
  return measurements.result();
}

Curve friction_response(const EvaluationSetup& setup, const std::vector<double>& coefficients) {
  constexpr std::size_t kPlaces = 10;
  const auto surface = make_surface(setup.shape);
  Random random(setup.seed);
  const std::vector<SurfaceSample> smooth = smooth_places(*surface, setup.tool, random);
  const std::vector<SurfaceSample> places = choose(smooth, kPlaces, random);
  const SceneIndex index = scene_of(*surface, setup, 0);
  Curve curve;
  for (const double coefficient : coefficients) {
    Hand hand(index, setup.tool, setup.model, coefficient);
    std::vector<double> measured;
    for (const SurfaceSample& place : places) {
      if (const auto one = measured_friction(hand, *surface, place, coefficient)) measured.push_back(*one);
    }
    curve.push_back({coefficient, spread_of(std::move(measured))});
  }
  return curve;
}

Spread force_ratio(const Evaluation& one, const Evaluation& other) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(one.held.size(), other.held.size()); ++i) {
    if (one.held[i] > 0.0 && other.held[i] > 0.0) ratios.push_back(one.held[i] / other.held[i]);
  }
  return spread_of(std::move(ratios));
}

}  // namespace palpate

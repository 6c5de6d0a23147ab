/// \file
/// Measurements of evaluate() at each place, one class each. Internal to study/.
///
/// Each class measures a place with `at`, and writes its results with `tell`.
#pragma once

#include <optional>
#include <vector>

#include <palpate/study/evaluation_hand.h>
#include <palpate/study/seen_surface.h>

namespace palpate {

/// Straight in.
class Presses {
 public:
  explicit Presses(const EvaluationSetup& setup);
  void at(Hand& hand, const SurfaceSample& place, const SeenSurface& scene);
  void tell(Evaluation& result) const;

 private:
  double stiffness_;
  std::size_t silent_ = 0, flipped_ = 0;
  std::vector<double> direction_, magnitude_, magnitude_seen_, seen_, onset_;
  CurveBins direction_at_, force_at_;
};

/// Along the surface, at an even depth.
class Slides {
 public:
  explicit Slides(const AnalyticSurface& surface) : surface_(surface) {}
  void at(Hand& hand, const SurfaceSample& place);
  void tell(Evaluation& result) const;

 private:
  void judge(const std::vector<Eigen::Vector3d>& forces, double depth);

  const AnalyticSurface& surface_;
  std::vector<double> held_, ripple_, jump_;
  std::vector<Eigen::Vector2d> first_;
  double first_depth_ = 0.0;
};

/// Around a circle and back to where it began.
class Loops {
 public:
  explicit Loops(double stiffness) : stiffness_(stiffness) {}
  void at(Hand& hand, const SurfaceSample& place);
  void tell(Evaluation& result) const { result.loop = spread_of(loop_); }

 private:
  double stiffness_;
  std::vector<double> loop_;
};

/// To the other side, if the model lets it.
class Pushes {
 public:
  explicit Pushes(const AnalyticSurface& surface, std::uint64_t seed) : surface_(surface), random_(seed) {}
  /// Somewhere among `places`. \throws Error if the surface has no place so far from its border as a push
  /// goes.
  void somewhere(Hand& hand, const std::vector<SurfaceSample>& places);
  void tell(Evaluation& result) const;

 private:
  /// A place, and which way.
  struct Aim {
    SurfaceSample place;
    Eigen::Vector3d along;
  };
  Aim aim(const Tool& tool, const std::vector<SurfaceSample>& places);
  bool is_through(const ForceOutput& felt, const Eigen::Vector3d& position, const Aim& aim,
                  double thickness) const;

  const AnalyticSurface& surface_;
  Random random_;
  std::size_t pushes_ = 0, through_ = 0, fast_ = 0, fast_through_ = 0;
};

/// Drag along over force against the true normal, means of a slide half as deep as the tool reaches; nothing
/// where it finds no room to slip. \param friction that the model is said to have.
std::optional<double> measured_friction(Hand& hand, const AnalyticSurface& surface,
                                        const SurfaceSample& place, double friction);

/// With friction: slides, and rests.
class Rubs {
 public:
  Rubs(const AnalyticSurface& surface, double friction) : surface_(surface), friction_(friction) {}
  void at(Hand& hand, const SurfaceSample& place);
  void tell(Evaluation& result) const;

 private:
  void rest(Hand& hand, const SurfaceSample& place);

  const AnalyticSurface& surface_;
  double friction_;
  std::vector<double> coefficient_, creep_;
};

}  // namespace palpate

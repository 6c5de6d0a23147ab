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

/// Presses along the normal.
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

/// Slides along the surface at constant depth.
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

/// Motion around closed circles.
class Loops {
 public:
  explicit Loops(double stiffness) : stiffness_(stiffness) {}
  void at(Hand& hand, const SurfaceSample& place);
  void tell(Evaluation& result) const { result.loop = spread_of(loop_); }

 private:
  double stiffness_;
  std::vector<double> loop_;
};

/// Pushes towards the other side of the surface.
class Pushes {
 public:
  explicit Pushes(const AnalyticSurface& surface, std::uint64_t seed) : surface_(surface), random_(seed) {}
  /// Pushes at a random one of `places`. \throws Error if the surface has no place far enough from its
  /// border.
  void somewhere(Hand& hand, const std::vector<SurfaceSample>& places);
  void tell(Evaluation& result) const;

 private:
  /// Place and direction of a push.
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

/// Measures drag over force along the true normal, means of a slide at a depth of half the tool's extent;
/// nothing if there is no room to slip. \param friction nominal coefficient of the model.
std::optional<double> measured_friction(Hand& hand, const AnalyticSurface& surface,
                                        const SurfaceSample& place, double friction);

/// Slides and rests with friction.
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

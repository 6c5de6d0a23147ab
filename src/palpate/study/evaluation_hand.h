/// \file
/// Tool motion through a scene, shared by the evaluations. Internal to study/.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include <palpate/haptics/tool_query.h>
#include <palpate/study/evaluation.h>
#include <palpate/study/random.h>

namespace palpate {

constexpr double kTick = 1e-3;                    // [s]
constexpr double kHandSpeed = 0.1;                // of all but pushes. [m/s]
constexpr double kHandStep = kHandSpeed * kTick;  // [m]

/// Number of ticks for a distance. Unit: [m].
inline int ticks_on(double way) { return static_cast<int>(std::ceil(way / kHandStep)); }

Tool ball(double radius);

/// Draws a unit vector with uniform distribution.
Eigen::Vector3d random_direction(Random& random);

/// Returns unit vector `k` of `count` evenly distributed ones: a spiral of golden angles.
Eigen::Vector3d even_direction(int k, int count);

/// Returns part / all; NaN if `all` is 0.
double share_of(std::size_t part, std::size_t all);

/// Returns the position of the tool's centre at which the point that touches first is `depth` below `place`.
/// The tool is oriented as the world. Unit: [m].
Eigen::Vector3d centre_at(const SurfaceSample& place, const Tool& tool, double depth);

/// Extent of the tool from its centre along -n. Unit: [m].
double reach(const Tool& tool, const Eigen::Vector3d& n);

/// Creates scene `k` of the setup, in 0 ... scenes-1.
GaussianScene gaussians_of(const AnalyticSurface& surface, const EvaluationSetup& setup, std::size_t k);
SceneIndex scene_of(const AnalyticSurface& surface, const EvaluationSetup& setup, std::size_t k);

/// Moves a tool through a scene tick by tick.
class Hand {
 public:
  Hand(const SceneIndex& index, const Tool& tool, const ForceModelMaker& model, double friction = 0.0)
      : tool_(tool), tracker_(index, tool), model_(model(index, tool, friction)) {}

  /// Resets the state to that without contact.
  void reset();

  /// Runs the next tick, with the tool at `position`.
  ForceOutput at(const Eigen::Vector3d& position);

  /// Moves the tool from one position to another at `speed`. Calls `visit(felt, s)` in every tick, at the
  /// distance s from `from`.
  template <class Visit>
  void move(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double speed, const Visit& visit) {
    const double length = (to - from).norm();
    const Eigen::Vector3d along = (to - from) / length;
    const int ticks = static_cast<int>(std::ceil(length / (speed * kTick)));
    for (int k = 0; k < ticks; ++k) {
      const double s = k * speed * kTick;
      visit(at(from + s * along), s);
    }
  }

  /// Resets the state, then approaches `place` along its normal to `depth`.
  void come_down(const SurfaceSample& place, double depth);

  const Tool& tool() const { return tool_; }
  /// Times of all ticks with a force so far. Unit: [us].
  const std::vector<double>& ticks() const { return ticks_; }

 private:
  Tool tool_;
  ToolTracker tracker_;
  std::unique_ptr<ForceModel> model_;
  ContactSet contacts_;
  bool moving_ = false;
  Eigen::Vector3d last_ = Eigen::Vector3d::Zero();
  std::vector<double> ticks_;
};

/// Largest change of the force beyond that of a spring under the tool's motion.
class ForceSteps {
 public:
  explicit ForceSteps(double stiffness) : stiffness_(stiffness) {}
  void add(const Eigen::Vector3d& force, const Eigen::Vector3d& position) {
    if (any_)
      largest_ = std::max(largest_, (force - force_).norm() - stiffness_ * (position - position_).norm());
    any_ = true;
    force_ = force;
    position_ = position;
  }
  double largest() const { return largest_; }

 private:
  double stiffness_, largest_ = 0.0;
  bool any_ = false;
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero(), position_ = Eigen::Vector3d::Zero();
};

/// Moves a place along its tangent by `step`, on the surface. Unit: [m].
SurfaceSample next_place(const AnalyticSurface& surface, const SurfaceSample& place, double step);

/// True if the tool touches the surface there and nowhere else.
bool tool_fits(const AnalyticSurface& surface, const SurfaceSample& place, const Tool& tool);

/// True if the surface has no border within about `margin` of `place`. Unit: [m].
bool is_inland(const AnalyticSurface& surface, const SurfaceSample& place, double margin);

/// True if the surface is also without edges and creases there. Unit: [m].
bool is_smooth(const AnalyticSurface& surface, const SurfaceSample& place, double margin);

}  // namespace palpate

/// \file
/// The felt surface near a solid: what is seen of the Gaussians from where the solid touches them.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include <Eigen/Core>

#include <palpate/geometry/ellipsoid.h>
#include <palpate/haptics/depth_view.h>
#include <palpate/haptics/look_budget.h>

namespace palpate {

/// A place where the tool touches or may soon touch: the plane that the surface has there. World frame.
struct SurfacePatch {
  Eigen::Vector3d normal;  ///< unit, towards the tool
  Eigen::Vector3d foot;    ///< the tool's own point that touches
  double gap = 0.0;        ///< from the surface to `foot`, along the normal; negative inside. Unit: [m].
  /// Confidence that there is a surface, in [1/2, 1]: 1 where Gaussians cover what the tool touches and hide
  /// what is behind them, less at what floats alone and where light comes through.
  double confidence = 1.0;
  double covered = 0.0;  ///< how much of its window something is seen in, weighted as in the fit
  /// Root mean square of the distance of what is seen from the fit. Unit: [m].
  double roughness = 0.0;

  // What is remembered from one look to the next.
  Eigen::Vector3d tangent;                            ///< of the views
  Eigen::Vector3d anchor;                             ///< of the lattice of rays
  Eigen::Vector3d sight;                              ///< what the nearest ray saw: one looks there again
  Eigen::Vector3d seen_at = Eigen::Vector3d::Zero();  ///< the foot when it was seen last
  Ellipsoid seen_by;                                  ///< the solid then
  Ellipsoid looked_by;                                ///< and when it was looked for last
  double offset = 0.0;  ///< of the felt surface over the fit, along the normal. Unit: [m].
  float light = 1.0F;   ///< that came there along the motion, through what is before it
  /// The Gaussian that is more than half of what is seen in it, if there is one.
  std::optional<std::uint32_t> mostly;

  Eigen::Vector3d on_surface() const { return foot - gap * normal; }
};

/// What a patch is made of: a Gaussian that is seen in it.
struct PatchWitness {
  std::uint32_t id;
  Eigen::Vector3d position;  ///< of its centre, world frame. Unit: [m].
  double weight;
};

/// How much of a surface there is where the moments were taken; see SurfacePatch::confidence.
/// \param seen that a ray lost half of its light there.
double confidence_of(const DepthMoments& moments, bool seen);

/// The patches that one solid of a tool touches, kept from one instant to the next. Takes nothing from the
/// heap after construction.
///
/// A patch looks at the scene against its normal, in a window of kWindow details around its foot
/// (DepthView). Which way it faces comes from all that is seen there,
///
///     minimise  sum_k w_k (z_k - a - b . u_k - u_k . C u_k)^2
///
/// over height a, slope b and curvature C, z_k the depth that ray k sees at u_k: moving least squares
/// (Levin 1998; Alexa et al. 2003) on the depth image instead of on points, so that what is hidden does not
/// count, nor how many Gaussians lie over each other. Where it is comes from the ray that the solid would
/// touch first: the felt surface is the fit, moved by an offset that follows, over two details of the way
/// that the foot goes, the least clearance of all rays. Where a patch is first met, the offset is such that
/// it is met where it is seen. Where it covers little of its window, as an edge does, it faces as the solid
/// does where it touches. What is not seen any more stays until the foot has moved on by half a detail, and
/// what lets light through recedes no faster than the tool moves along it.
class SurfacePatches {
 public:
  /// As many constraints as a rigid body has degrees of freedom, and two to choose from.
  static constexpr std::size_t kMost = 8;

  /// \param detail the scale of the fit. Unit: [m]. > 0 \param larger how many times its semi-axes are those
  /// of the solid that the scene is looked at in \param budget of all parts of a tool, which must outlive it
  SurfacePatches(double detail, const Eigen::Vector3d& larger, LookBudget& budget)
      : detail_(detail), larger_(larger), budget_(budget), view_(std::make_unique<DepthView>()) {}

  /// Radius of the window of a patch, in details: its kernel, of the form (1 - r^2)^3, has a deviation of
  /// 0.32 of that.
  static constexpr double kWindow = 2.6;

  double detail() const { return detail_; }
  void clear() {
    size_ = 0;
    light_ = RayLight();
  }

  /// Fits the patches anew where `solid` is now, and drops those that are not there any more. Where the
  /// budget is spent, they stay.
  void follow(const LocalSplats& splats, const Ellipsoid& solid);

  /// Looks along the unit vector `along` for what the solid, moved that way by `way`, would touch and no
  /// patch explains, most closely about the point `about`; each such place becomes a patch if `admit()` lets
  /// it. \returns how far it may go without another look; nothing where the budget did not allow to
  /// look, or to look for what else there is. Unit: [m].
  /// \param head_on if above 0, only walls count that the solid meets with its front: the least cosine
  /// between `along` and its outward normal there
  template <class Admit>
  std::optional<double> look_ahead(const LocalSplats& splats, const Ellipsoid& solid,
                                   const Eigen::Vector3d& along, const Eigen::Vector3d& about, double way,
                                   double head_on, const Admit& admit) {
    double clear = 0.0;
    while (size_ < kMost) {
      if (budget_.is_spent()) return std::nullopt;
      Meeting meeting;
      clear = meet(splats, solid, along, about, way, head_on, meeting);
      if (clear > way || !admit()) break;
      if (!add(splats, solid, meeting, head_on > 0.0)) break;
    }
    return clear;
  }

  /// A patch where the tool is in something already: faced along `normal` at `point`. \returns false if
  /// nothing is seen there.
  bool add_at(const LocalSplats& splats, const Ellipsoid& solid, const Eigen::Vector3d& normal,
              const Eigen::Vector3d& point);

  std::span<const SurfacePatch> patches() const { return {patches_.data(), size_}; }
  /// What patch `i` was made of in the last follow(), look_ahead() or add_at(). Weights add up to 1, or there
  /// are none.
  std::span<const PatchWitness> witnesses(std::size_t i) const {
    return {witnesses_[i].data(), witness_count_[i]};
  }

 private:
  /// What is seen first along a motion.
  struct Meeting {
    Eigen::Vector3d along, point;
    double clearance = 0.0;
    float light = 1.0F;  ///< that was left on the way there
  };
  /// What a patch sees.
  struct Look {
    double fitted = 0.0;  ///< gap of the fit. Unit: [m].
    double least = 0.0;   ///< gap by the nearest ray. Unit: [m].
  };

  double meet(const LocalSplats& splats, const Ellipsoid& solid, const Eigen::Vector3d& along,
              const Eigen::Vector3d& about, double way, double head_on, Meeting& meeting);
  bool add(const LocalSplats& splats, const Ellipsoid& solid, const Meeting& meeting, bool only_wall);
  bool look(const LocalSplats& splats, const Ellipsoid& solid, SurfacePatch& patch, Look& look);
  /// Light that the rays of a free motion still have, for a look from `solid` along `along`.
  void carry_light(const Ellipsoid& solid, const Eigen::Vector3d& along);
  /// \param of the Gaussian that is seen there, if one knows
  bool explained(const Ellipsoid& solid, const Eigen::Vector3d& point, std::optional<std::uint32_t> of) const;
  /// Fits a patch anew. \returns false if nothing is seen there.
  bool see_again(const LocalSplats& splats, const Ellipsoid& solid, SurfacePatch& patch);
  /// Leaves a patch where it was. \returns false if the tool is not there any more.
  bool stay(const Ellipsoid& solid, SurfacePatch& patch) const;
  bool keep(const SurfacePatch& patch);
  void remember_witnesses(std::size_t i);

  double detail_;
  Eigen::Vector3d larger_;
  LookBudget& budget_;
  std::unique_ptr<DepthView> view_;
  RayLight light_;  ///< of the last look along a free motion
  Eigen::Vector3d light_from_ = Eigen::Vector3d::Zero(), light_along_ = Eigen::Vector3d::Zero();
  std::size_t size_ = 0;
  std::array<SurfacePatch, kMost> patches_;
  std::array<std::array<PatchWitness, DepthView::kRegular>, kMost> witnesses_;
  std::array<std::size_t, kMost> witness_count_{};
  std::array<PatchWitness, DepthView::kRegular> seen_;  ///< in the last look
  std::size_t seen_count_ = 0;
};

}  // namespace palpate

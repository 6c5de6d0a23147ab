/// \file
/// Surface patches near a solid: local surface fits to the Gaussians seen from its points of contact.
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include <Eigen/Core>

#include <palpate/geometry/ellipsoid.h>
#include <palpate/haptics/depth_view.h>
#include <palpate/haptics/work_budget.h>

namespace palpate {

/// Mean material of the Gaussians that a patch is fitted to.
struct PatchMaterial {
  double stiffness, friction, damping;  ///< see Material
};

/// Tangent plane of the surface where the tool touches or may soon touch. World frame.
struct SurfacePatch {
  Eigen::Vector3d normal;  ///< unit, towards the tool
  Eigen::Vector3d foot;    ///< the contact point on the tool
  double gap = 0.0;        ///< from the surface to `foot`, along the normal; negative inside. Unit: [m].
  /// Confidence that there is a surface, in [1/2, 1]: 1 where Gaussians cover the contact region and are
  /// opaque, less at isolated floaters and translucent places.
  double confidence = 1.0;
  double covered = 0.0;  ///< fraction of the window with hits, weighted as in the fit
  /// Root mean square distance of the hits from the fit. Unit: [m].
  double roughness = 0.0;

  // State kept from one view to the next.
  Eigen::Vector3d tangent;                            ///< of the views
  Eigen::Vector3d anchor;                             ///< of the lattice of rays
  Eigen::Vector3d sight;                              ///< hit of the nearest ray, the aim of the next view
  Eigen::Vector3d seen_at = Eigen::Vector3d::Zero();  ///< the foot at the last hit
  Ellipsoid seen_by;                                  ///< the solid at that time
  Ellipsoid viewed_from;                              ///< the solid at the last view
  double offset = 0.0;  ///< of the rendered surface over the fit, along the normal. Unit: [m].
  float light = 1.0F;   ///< transmittance along the motion up to here
  /// The Gaussian that accounts for more than half of the hits, if there is one.
  std::optional<std::uint32_t> mostly;
  /// See SurfacePatches::set_material(); unset again where the patch is fitted to another view.
  std::optional<PatchMaterial> material;

  Eigen::Vector3d on_surface() const { return foot - gap * normal; }
};

/// A Gaussian that contributes to a patch.
struct PatchWitness {
  std::uint32_t id;
  Eigen::Vector3d position;  ///< of its centre, world frame. Unit: [m].
  double weight;
};

/// Returns the confidence that a surface exists where the moments were taken; see SurfacePatch::confidence.
/// \param seen true if a ray lost half of its light there.
double confidence_of(const DepthMoments& moments, bool seen);

/// The patches that one solid of a tool touches, tracked over time. Does not allocate after construction.
///
/// A patch views the scene against its normal, in a window of kWindow details around its foot (DepthView).
/// Its orientation comes from all hits,
///
///     minimise  sum_k w_k (z_k - a - b . u_k - u_k . C u_k)^2
///
/// over height a, slope b and curvature C, z_k the depth that ray k sees at u_k: moving least squares (Levin
/// 1998; Alexa et al. 2003) on the depth image instead of on points, so that neither hidden Gaussians nor
/// their number in overlapping layers matter. Its position comes from the ray that the solid would touch
/// first: the rendered surface is the fit, shifted by an offset that follows the least clearance of all rays
/// over two details of travel of the foot. At first contact the offset is such that contact occurs at the
/// hit. A patch that covers little of its window, as at an edge, is oriented as the solid at its contact
/// point. A patch without hits remains until the foot has moved by half a detail, and a translucent surface
/// recedes no faster than the tool moves along it.
class SurfacePatches {
 public:
  /// One constraint for each degree of freedom of a rigid body, and two spare.
  static constexpr std::size_t kMost = 8;

  /// \param detail the scale of the fit. Unit: [m]. > 0 \param larger factors from the solid's semi-axes to
  /// those of the solid in which the scene is viewed \param budget of all parts of a tool; must outlive this
  /// object
  SurfacePatches(double detail, const Eigen::Vector3d& larger, WorkBudget& budget)
      : detail_(detail), larger_(larger), budget_(budget), view_(std::make_unique<DepthView>()) {}

  /// Radius of the window of a patch, in details: its kernel, of the form (1 - r^2)^3, has a standard
  /// deviation of 0.32 of that.
  static constexpr double kWindow = 2.6;

  double detail() const { return detail_; }
  void clear() {
    size_ = 0;
    light_ = RayLight();
  }

  /// Refits the patches at the present pose of `solid`, and drops those that no longer exist. If the budget
  /// is spent, the remaining ones are kept unchanged.
  void follow(const LocalSplats& splats, const Ellipsoid& solid);
  /// Moves the feet of the patches with `solid`, without a view.
  void carry(const Ellipsoid& solid);

  /// Searches along the unit vector `along` for surfaces that the solid, moved that way by `way`, would touch
  /// and no patch covers, at highest resolution about the point `about`; each becomes a patch if `admit()`
  /// permits, in place of another one if there are kMost (see place_for()). \returns how far the solid may
  /// move without another view; nothing if the budget did not allow a view, or a further one after a patch
  /// was added. Unit: [m]. \param head_on if above 0, only surfaces met head-on count: the least cosine
  /// between `along` and its outward normal there
  template <class Admit>
  std::optional<double> view_ahead(const LocalSplats& splats, const Ellipsoid& solid,
                                   const Eigen::Vector3d& along, const Eigen::Vector3d& about, double way,
                                   double head_on, const Admit& admit) {
    // No more than kMost rounds: each adds one, and none that was added makes room for another.
    for (std::bitset<kMost> added;;) {
      if (budget_.is_spent()) return std::nullopt;
      Meeting meeting;
      const double clear = meet(splats, solid, along, about, way, head_on, meeting);
      if (clear > way || !admit()) return clear;
      const std::size_t place = place_for(meeting, added);
      if (place == kMost || !add(splats, solid, meeting, head_on > 0.0, place)) return clear;
      added.set(place);
    }
  }

  /// Adds a patch where the tool is inside an object already: facing along `normal` at `point`. \returns
  /// false if there are no hits.
  bool add_at(const LocalSplats& splats, const Ellipsoid& solid, const Eigen::Vector3d& normal,
              const Eigen::Vector3d& point);

  std::span<const SurfacePatch> patches() const { return {patches_.data(), size_}; }
  /// Number of patches that have been added so far.
  std::size_t added() const { return added_; }
  /// Gaussians that patch `i` was fitted to in the last follow(), view_ahead() or add_at(). The weights sum
  /// to 1; empty if there are none.
  std::span<const PatchWitness> witnesses(std::size_t i) const {
    return {witnesses_[i].data(), witness_count_[i]};
  }
  /// Remembers the material of the witnesses of patch `i`, whose lookup takes time, for as long as they are
  /// the same.
  void set_material(std::size_t i, const PatchMaterial& material) { patches_[i].material = material; }

 private:
  /// First hit along a motion.
  struct Meeting {
    Eigen::Vector3d along, point;
    double clearance = 0.0;
    float light = 1.0F;  ///< transmittance up to there
  };
  /// Result of the view of a patch.
  struct ViewGaps {
    double fitted = 0.0;  ///< gap of the fit. Unit: [m].
    double least = 0.0;   ///< gap by the nearest ray. Unit: [m].
  };

  double meet(const LocalSplats& splats, const Ellipsoid& solid, const Eigen::Vector3d& along,
              const Eigen::Vector3d& about, double way, double head_on, Meeting& meeting);
  /// Returns where a patch of `meeting` is stored: behind the others or, if there are kMost, in place of the
  /// one that the solid is farthest in front of when it has come to the new surface, other than those in
  /// `added`; kMost if it is inside of all of them by then. What makes room is seen again before it is met.
  std::size_t place_for(const Meeting& meeting, const std::bitset<kMost>& added) const;
  bool add(const LocalSplats& splats, const Ellipsoid& solid, const Meeting& meeting, bool only_wall,
           std::size_t place);
  bool view(const LocalSplats& splats, const Ellipsoid& solid, SurfacePatch& patch, ViewGaps& gaps);
  /// Carries the transmittance of rays over a free motion, to a view from `solid` along `along`.
  void carry_light(const Ellipsoid& solid, const Eigen::Vector3d& along);
  /// Returns true if an existing patch covers `point`. \param of the Gaussian hit there, if known
  bool explained(const Ellipsoid& solid, const Eigen::Vector3d& point, std::optional<std::uint32_t> of) const;
  /// Refits a patch. \returns false if there are no hits.
  bool see_again(const LocalSplats& splats, const Ellipsoid& solid, SurfacePatch& patch);
  /// Keeps a patch unchanged. \returns false if the tool has moved away from it.
  bool stay(const Ellipsoid& solid, SurfacePatch& patch) const;
  /// Stores a patch at `place`, at most size_, unless it is one with another. \returns false if so
  bool keep(const SurfacePatch& patch, std::size_t place);
  void remember_witnesses(std::size_t i);

  double detail_;
  Eigen::Vector3d larger_;
  WorkBudget& budget_;
  std::unique_ptr<DepthView> view_;
  RayLight light_;  ///< of the last view along a free motion
  Eigen::Vector3d light_from_ = Eigen::Vector3d::Zero(), light_along_ = Eigen::Vector3d::Zero();
  std::size_t size_ = 0, added_ = 0;
  std::array<SurfacePatch, kMost> patches_;
  std::array<std::array<PatchWitness, DepthView::kRegular>, kMost> witnesses_;
  std::array<std::size_t, kMost> witness_count_{};
  std::array<PatchWitness, DepthView::kRegular> seen_;  ///< in the last view
  std::size_t seen_count_ = 0;
};

}  // namespace palpate

/// \file
/// What is seen of the Gaussians around a tool, looking along one direction: a depth image of a few rays.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <Eigen/Core>

#include <palpate/collision/local_splats.h>
#include <palpate/geometry/ellipsoid.h>

namespace palpate {

/// An orthographic view. World frame; lengths in m.
struct ViewFrame {
  Eigen::Vector3d origin;  ///< of depths and of places (x, y) in the image
  Eigen::Vector3d u, v;    ///< unit; the image's axes
  Eigen::Vector3d w;       ///< unit; where it looks, depth is positive that way. u, v, w are orthonormal.

  /// A view along `w` whose u is as near to `u` as can be.
  static ViewFrame along(const Eigen::Vector3d& w, const Eigen::Vector3d& origin, const Eigen::Vector3d& u);

  Eigen::Vector3d at(double x, double y, double depth) const { return origin + x * u + y * v + depth * w; }
};

/// The far side of an ellipsoid in a view whose origin is its centre: how deep it reaches at (x, y),
///
///     depth = (sqrt(c . c - |x a + y b|^2) - (x d + y e)) / c . c
///
/// with c = B w, a = (B u) x c, b = (B v) x c, d = B u . c, e = B v . c and B the inverse of its axes.
struct Profile {
  Profile(const Ellipsoid& solid, const ViewFrame& view);

  float aa, ab, bb, cc, d, e;

  /// Of c . c, what must be left of it for a place to count as below the solid: nearer to the silhouette, the
  /// solid's side is steeper than a depth image can tell.
  static constexpr float kLeastFacing = 4e-4F;

  /// True if (x, y) is below the solid and not at its very side.
  bool below(float x, float y) const;
  float depth(float x, float y) const;
};

/// Where the regular rays of a look are.
struct RayPattern {
  static constexpr std::size_t kMost = 64;

  /// The points of a triangular lattice, one of which is `anchor`, in an ellipse about `center`. \param shape
  /// the unit disc to the ellipse; the lattice is regular in that disc. Unit: [m].
  RayPattern(const Eigen::Matrix2d& shape, const Eigen::Vector2d& center, const Eigen::Vector2d& anchor);

  Eigen::Vector2d center;   ///< in the image. Unit: [m].
  Eigen::Vector2d aim;      ///< of one more ray. Unit: [m].
  double reach;             ///< of the rays from the centre, at most. Unit: [m].
  Eigen::Vector2d anchor;   ///< Unit: [m].
  Eigen::Matrix2d to_cell;  ///< the image to where neighbours are 1 apart
  std::size_t size = 0;
  std::array<Eigen::Vector2f, kMost> places;  ///< in the image. Unit: [m].

  /// More rays, about `aim`.
  static constexpr std::size_t kAround = 16;
  std::size_t around_size = 0;
  std::array<Eigen::Vector2f, kAround> around;  ///< in the image. Unit: [m].

  /// Evenly spread over an ellipse about the origin, which a solid covers that is deepest at `lowest`: where
  /// that is not in the middle, as under a rod that stands aslant, more of them are about it. \param shape
  /// the unit disc to the ellipse. Unit: [m].
  static RayPattern over_ellipse(const Eigen::Matrix2d& shape, const Eigen::Vector2d& lowest);
  /// The points of a triangular lattice, one of which is `anchor`, that are in a disc: as the disc moves on,
  /// rays come and go at its rim, and look at the same places meanwhile. `anchor` becomes one that is near
  /// the centre.
  static RayPattern on_lattice(const Eigen::Vector2d& center, double radius, Eigen::Vector2d& anchor);
};

/// What is left of the light of each regular ray where a look begins.
struct RayLight {
  explicit RayLight(float all = 1.0F) { left.fill(all); }

  double since =
      std::numeric_limits<double>::infinity();  ///< at this depth, or where the look begins. Unit: [m].
  std::array<float, RayPattern::kMost> left;    ///< in [DepthView::kSeen, 1]
};

/// Sums over the regular rays that hit something, with b = (1, x, y, x^2 + y^2, x^2 - y^2, 2 x y), x and y
/// from the kernel's centre and all lengths in its unit.
struct DepthMoments {
  static constexpr std::size_t kTerms = 6;
  std::array<float, kTerms*(kTerms + 1) / 2>
      normal_matrix{};                ///< of w b_i b_j: the upper triangle, row by row
  std::array<float, kTerms> right{};  ///< of w b_i z
  float hit = 0.0F;                   ///< of w
  float residual = 0.0F;              ///< of w (z - fit)^2
  float aimed = 0.0F;                 ///< of the kernel alone, over all regular rays
  float seen_through = 0.0F;          ///< of w times the transmittance that is left behind what was hit

  /// How much of the kernel something is seen in. \pre `aimed` is above zero
  double covered() const { return static_cast<double>(hit / aimed); }
};

/// What moments() weighs rays with: w = h (1 - (x^2 + y^2) / end^2)^3 / (1 + (z - fit)^2 / spread^2), with h
/// the share of what a ray would meet of a wall that hides all.
struct DepthKernel {
  Eigen::Vector2d center;  ///< in the image. Unit: [m].
  double unit;             ///< of all other lengths. Unit: [m].
  double level;            ///< depth that z is counted from. Unit: [m].
  float end;               ///< where it ends
  std::array<float, DepthMoments::kTerms> fit{};
  float spread = 1.0F;
};

/// A splat in a view: about (px, py), m^2 = quu dx^2 + quv dx dy + qvv dy^2 of the way from there, and a ray
/// at (x, y) meets it at the depth t0 + x tx + y ty. Unit: [m].
struct SplatImage {
  float px, py;
  float t0, tx, ty;
  float quu, quv, qvv;
  float log_alpha;
  std::uint32_t number;
  std::uint32_t blocks;  ///< a bit for each block of rays that may meet it
};

/// Splatting for touch (Kerbl et al. 2023, for a handful of rays instead of pixels). A Gaussian is met where
/// the ray is nearest to it by its own measure, with alpha exp(-m^2 / 2), at most 0.99, front to back by the
/// depth of its centre; what a ray meets when its transmittance falls below kSeen is what is seen there.
/// Regular rays fill a window evenly; besides, there is one in its middle, one that is aimed
/// (RayPattern::aim), and some through the centres of what is nearest below the solid.
///
/// What is fitted to (moments()) is not that depth but the mean depth of where the light falls from three
/// quarters to one quarter, which does not jump from one Gaussian to the next.
///
/// Belongs to one thread. Takes nothing from the heap after construction.
class DepthView {
 public:
  static constexpr std::size_t kRegular = RayPattern::kMost, kSought = 16,
                               kExtra = kSought + RayPattern::kAround, kRays = kRegular + kExtra;

  /// Looks at those of `splats` that reach into `larger`, below the solid of `profile`; both solids' centre
  /// is the view's origin. Nothing is seen that is nearer than the depth `start`, but from `light.since` on
  /// it takes light away: no more than down to kSeen, since what has not been felt there will not be. `light`
  /// is then what is left at `start`. Unit: [m].
  /// \param known a depth that rays begin at least at, even where that is behind the solid: where something
  /// has been seen before. Unit: [m].
  void look(const LocalSplats& splats, const ViewFrame& view, const Profile& profile, const Ellipsoid& larger,
            const RayPattern& pattern, double start, RayLight& light,
            double known = std::numeric_limits<double>::infinity());

  /// \name Of the last look
  /// @{
  std::size_t in_window() const { return size_; }     ///< Gaussians that were near the rays
  std::size_t drawn() const { return image_count_; }  ///< those of them that rays may have met
  /// @}

  /// \name Of ray k: regular ones first.
  /// @{
  float x(std::size_t k) const { return x_[k]; }
  float y(std::size_t k) const { return y_[k]; }
  float depth(std::size_t k) const { return depth_[k]; }  ///< infinite where nothing is seen. Unit: [m].
  bool hits(std::size_t k) const { return depth_[k] < kNothing; }
  std::uint32_t splat(std::size_t k) const { return splat_[k]; }  ///< what is seen, by number in the splats
  float incoming(std::size_t k) const { return incoming_[k]; }    ///< its light at `start`
  /// @}

  /// From the far side of the solid to what ray k sees, along the view; infinite where that sees nothing or
  /// is not below the solid. Unit: [m].
  float clearance(std::size_t k) const { return clearance_[k]; }
  /// The ray with the least of them; kRays if there is none.
  std::size_t nearest() const;

  DepthMoments moments(const DepthKernel& kernel) const;

  static constexpr float kNothing = 1e30F;
  /// What is left of the light where something is seen. An eye sees a surface where half of it is left, at
  /// the densest place before the tool; rays are a quarter of the window apart, and the densest of a few are
  /// not as dense as that. With this, as many pushes at captures are felt before the place that is seen as
  /// behind.
  static constexpr float kSeen = 0.55F;

  /// What is left of the light where a ray is not followed further.
  static constexpr float kDark = 0.1F;

  /// Rays that are near each other, and are asked together.
  static constexpr std::size_t kBlock = 16, kBlocks = kRays / kBlock;

  /// The rectangles that they are in.
  struct RayBlocks {
    std::array<float, kBlocks> low_x, high_x, low_y, high_y;
  };

 private:
  friend struct DepthViewLanes;
  static constexpr std::size_t kMost = LocalSplats::kCapacity;
  template <typename T>
  using PerSplat = std::array<T, kMost + kIndexWidth>;
  template <typename T>
  using PerRay = std::array<T, kRays>;

  void aim_extra_rays(const RayPattern& pattern, const RayLight& light);
  std::size_t nearest_regular(float x, float y) const;
  void bound_blocks();
  void order(std::size_t count);
  SplatImage image(std::size_t i, std::uint32_t blocks) const {
    return {px_[i],  py_[i],  t0_[i],        tx_[i],     ty_[i], quu_[i],
            quv_[i], qvv_[i], log_alpha_[i], number_[i], blocks};
  }

  alignas(64) PerRay<float> x_{}, y_{}, depth_{}, sum_{}, share_{}, left_{}, incoming_{}, near_{}, far_{},
      begin_{}, clearance_{};
  alignas(64) PerRay<std::uint32_t> splat_{};
  alignas(64) std::array<PerSplat<float>, 3> from_;  ///< the view's origin to each splat. Unit: [m].
  // Of the splats that are in the window, in no order: depth t0 + x tx + y ty, and m^2 as a quadratic form
  // of the way from (px, py).
  std::size_t size_ = 0;
  alignas(64) PerSplat<float> t0_, tx_, ty_, px_, py_, quu_, quv_, qvv_, log_alpha_;
  alignas(64) PerSplat<float> key_, below_, regular_, half_width_, half_height_;
  alignas(64) PerSplat<std::uint32_t> number_;
  // Of those that rays may meet: number in the above, blocks of rays and part of the order.
  static constexpr std::uint32_t kBins = 512;
  alignas(64) PerSplat<std::uint32_t> chosen_, chosen_blocks_, bin_;
  // The same, front to back.
  std::size_t image_count_ = 0;
  std::array<SplatImage, kMost> images_;
  RayBlocks blocks_;
};

}  // namespace palpate

/// \file
/// Depth image of the Gaussians around a tool along one direction, with a few rays.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <Eigen/Core>

#include <palpate/collision/local_splats.h>
#include <palpate/geometry/ellipsoid.h>

namespace palpate {

/// An orthographic view. World frame; lengths in m.
struct ViewFrame {
  Eigen::Vector3d origin;  ///< of depths and of places (x, y) in the image
  Eigen::Vector3d u, v;    ///< unit; the image's axes
  Eigen::Vector3d w;       ///< unit; viewing direction, of positive depth. u, v, w are orthonormal.

  /// Returns a view along `w` whose u is as near to `u` as possible.
  static ViewFrame along(const Eigen::Vector3d& w, const Eigen::Vector3d& origin, const Eigen::Vector3d& u);

  Eigen::Vector3d at(double x, double y, double depth) const { return origin + x * u + y * v + depth * w; }
};

/// The far side of an ellipsoid in a view whose origin is its centre: its depth at (x, y),
///
///     depth = (sqrt(c . c - |x a + y b|^2) - (x d + y e)) / c . c
///
/// with c = B w, a = (B u) x c, b = (B v) x c, d = B u . c, e = B v . c and B the inverse of its axes.
struct Profile {
  Profile(const Ellipsoid& solid, const ViewFrame& view);

  float aa, ab, bb, cc, d, e;

  /// Least fraction of c . c for a place to count as below the solid: nearer to the silhouette, the solid's
  /// side is too steep for a depth image.
  static constexpr float kLeastFacing = 4e-4F;

  /// Returns true if (x, y) is below the solid and not close to its silhouette.
  bool below(float x, float y) const;
  float depth(float x, float y) const;
};

/// Positions of the rays of a view.
struct RayPattern {
  static constexpr std::size_t kMost = 64;

  /// The points of a triangular lattice, one of which is `anchor`, in an ellipse about `center`. \param shape
  /// the unit disc to the ellipse; the lattice is regular in that disc. Unit: [m].
  RayPattern(const Eigen::Matrix2d& shape, const Eigen::Vector2d& center, const Eigen::Vector2d& anchor);

  Eigen::Vector2d center;   ///< in the image. Unit: [m].
  Eigen::Vector2d aim;      ///< of one additional ray. Unit: [m].
  double reach;             ///< largest distance of a ray from the centre. Unit: [m].
  Eigen::Vector2d anchor;   ///< Unit: [m].
  Eigen::Matrix2d to_cell;  ///< from the image to lattice coordinates with unit spacing
  std::size_t size = 0;
  std::array<Eigen::Vector2f, kMost> places;  ///< in the image. Unit: [m].

  /// Additional rays, about `aim`.
  static constexpr std::size_t kAround = 16;
  std::size_t around_size = 0;
  std::array<Eigen::Vector2f, kAround> around;  ///< in the image. Unit: [m].

  /// Spreads rays evenly over an ellipse about the origin, covered by a solid that is deepest at `lowest`. If
  /// that is off-centre, as under a tilted rod, more rays are placed about it. \param shape the unit disc to
  /// the ellipse. Unit: [m].
  static RayPattern over_ellipse(const Eigen::Matrix2d& shape, const Eigen::Vector2d& lowest);
  /// Places rays at the points of a triangular lattice, one of which is `anchor`, that are in a disc: as the
  /// disc moves, rays are added and dropped at its rim only and otherwise keep their places. `anchor` becomes
  /// a lattice point near the centre.
  static RayPattern on_lattice(const Eigen::Vector2d& center, double radius, Eigen::Vector2d& anchor);
};

/// Transmittance of each regular ray where a view begins.
struct RayLight {
  explicit RayLight(float all = 1.0F) { left.fill(all); }

  double since =
      std::numeric_limits<double>::infinity();  ///< from this depth, or the beginning of the view. Unit: [m].
  std::array<float, RayPattern::kMost> left;    ///< in [DepthView::kSeen, 1]
};

/// Weighted sums over the regular rays with a hit, with b = (1, x, y, x^2 + y^2, x^2 - y^2, 2 x y), x and y
/// from the kernel's centre and all lengths in its unit.
struct DepthMoments {
  static constexpr std::size_t kTerms = 6;
  std::array<float, kTerms*(kTerms + 1) / 2>
      normal_matrix{};                ///< of w b_i b_j: the upper triangle, row by row
  std::array<float, kTerms> right{};  ///< of w b_i z
  float hit = 0.0F;                   ///< of w
  float residual = 0.0F;              ///< of w (z - fit)^2
  float aimed = 0.0F;                 ///< of the kernel alone, over all regular rays
  float seen_through = 0.0F;          ///< of w times the transmittance behind the hit

  /// Fraction of the kernel with a hit. \pre `aimed` is above zero
  double covered() const { return static_cast<double>(hit / aimed); }
};

/// Weight of the rays in moments(): w = h (1 - (x^2 + y^2) / end^2)^3 / (1 + (z - fit)^2 / spread^2), with h
/// the fraction of the opacity relative to an opaque wall.
struct DepthKernel {
  Eigen::Vector2d center;  ///< in the image. Unit: [m].
  double unit;             ///< unit of all other lengths. Unit: [m].
  double level;            ///< depth that z is counted from. Unit: [m].
  float end;               ///< radius of its support
  std::array<float, DepthMoments::kTerms> fit{};
  float spread = 1.0F;
};

/// A splat in a view: m^2 = quu dx^2 + quv dx dy + qvv dy^2 with (dx, dy) measured from (px, py), and a ray
/// at (x, y) meets it at the depth t0 + x tx + y ty. Unit: [m].
struct SplatImage {
  float px, py;
  float t0, tx, ty;
  float quu, quv, qvv;
  float log_alpha;
  std::uint32_t number;
  std::uint32_t blocks;  ///< one bit for each block of rays that may meet it
};

/// Splatting for touch (Kerbl et al. 2023, for a few rays instead of pixels). A ray meets a Gaussian where
/// its Mahalanobis distance m is least, with opacity alpha exp(-m^2 / 2), at most 0.99, front to back by the
/// depth of the centre; the Gaussian at which the transmittance falls below kSeen is the hit. Regular rays
/// fill a window evenly; there is also one in its middle, one at RayPattern::aim, and some that meet the
/// Gaussians nearest below the solid, where those are nearest to it.
///
/// moments() uses not that depth but the mean depth over which the transmittance falls from three quarters to
/// one quarter, which does not jump between Gaussians.
///
/// Used by one thread. Does not allocate after construction.
class DepthView {
 public:
  static constexpr std::size_t kRegular = RayPattern::kMost, kSought = 16,
                               kExtra = kSought + RayPattern::kAround, kRays = kRegular + kExtra;

  /// Renders those of `splats` that reach into `larger`, below the solid of `profile`; both solids' centre is
  /// the view's origin. Gaussians nearer than the depth `start` give no hit but attenuate the rays from
  /// `light.since` on, at most down to kSeen, since they were not felt there before. `light` then holds the
  /// transmittance at `start`. Unit: [m]. \param known depth of an earlier hit, from which rays begin at the
  /// latest, even if it is behind the solid. Unit: [m].
  void render(const LocalSplats& splats, const ViewFrame& view, const Profile& profile,
              const Ellipsoid& larger, const RayPattern& pattern, double start, RayLight& light,
              double known = std::numeric_limits<double>::infinity());

  /// \name Statistics of the last view
  /// @{
  std::size_t in_window() const { return size_; }     ///< Gaussians near the rays
  std::size_t drawn() const { return image_count_; }  ///< those of them that rays may meet
  /// @}

  /// \name Results of ray k; regular rays come first
  /// @{
  float x(std::size_t k) const { return x_[k]; }
  float y(std::size_t k) const { return y_[k]; }
  float depth(std::size_t k) const { return depth_[k]; }  ///< infinite without a hit. Unit: [m].
  bool hits(std::size_t k) const { return depth_[k] < kNothing; }
  std::uint32_t splat(std::size_t k) const {
    return splat_[k];
  }                                                             ///< the Gaussian hit, by number in the splats
  float incoming(std::size_t k) const { return incoming_[k]; }  ///< its transmittance at `start`
  /// @}

  /// Distance from the far side of the solid to the hit of ray k, along the view; infinite without a hit or
  /// if the ray is not below the solid. Unit: [m].
  float clearance(std::size_t k) const { return clearance_[k]; }
  /// Returns the ray with the least clearance; kRays if there is none.
  std::size_t nearest() const;

  DepthMoments moments(const DepthKernel& kernel) const;

  static constexpr float kNothing = 1e30F;
  /// Transmittance at a hit. An eye sees a surface where half of the light is left, at the densest place
  /// before the tool; rays are a quarter of the window apart, and the densest of a few is less dense. With
  /// this value, as many contacts with captured scenes are felt in front of the visible surface as behind it.
  static constexpr float kSeen = 0.55F;

  /// Transmittance at which a ray ends.
  static constexpr float kDark = 0.1F;

  /// Blocks of neighbouring rays that are evaluated together.
  static constexpr std::size_t kBlock = 16, kBlocks = kRays / kBlock;

  /// Bounding rectangles of the blocks.
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

  /// A place of a Gaussian, with its distance from the solid along the view. Unit: [m].
  struct NearPlace {
    float x, y, clearance;
  };
  static constexpr std::size_t kFixed = 2;

  void aim_extra_rays(const RayPattern& pattern, std::span<const NearPlace> nearest, const RayLight& light);
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
  alignas(64) PerSplat<float> key_, regular_, half_width_, half_height_;
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

#include <palpate/scene/scene_setup.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/base/quantile.h>
#include <palpate/scene/lint.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr std::array kAxes{'x', 'y', 'z'};
constexpr std::array<std::array<UpAxis, 2>, 3> kUpAxes{
    {{UpAxis::kXDown, UpAxis::kXUp}, {UpAxis::kYDown, UpAxis::kYUp}, {UpAxis::kZDown, UpAxis::kZUp}}};

/// A Gaussian that can collide, as a piece of surface.
struct Piece {
  Vector3d position, normal;
  double longest;  ///< standard deviation
  double opacity;
  double seen;  ///< opacity times area
  bool flat;    ///< enough for a meaningful normal
};

std::vector<Piece> pieces_of(const GaussianScene& scene) {
  constexpr double kFlat = 0.5;  // largest ratio of the shortest to the middle axis
  std::vector<Piece> pieces;
  pieces.reserve(scene.size());
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const Gaussian g = scene.gaussian(i);
    if (defect(scene, i, g) != Defect::kNone) continue;
    Eigen::Index shortest = 0;
    const double least = g.sigma.minCoeff(&shortest), most = g.sigma.maxCoeff();
    const double middle = g.sigma.sum() - least - most;
    pieces.push_back({g.position, g.rotation * Vector3d::Unit(shortest), most, g.opacity,
                      g.opacity * most * middle, least < kFlat * middle});
  }
  return pieces;
}

double quantile_of(const std::vector<Piece>& pieces, double share, const auto& value) {
  std::vector<double> values;
  values.reserve(pieces.size());
  for (const Piece& piece : pieces) values.push_back(value(piece));
  return quantile(values, share);
}

Eigen::AlignedBox3d central_box(const std::vector<Piece>& pieces) {
  constexpr double kOutside = 0.01;  // fraction on each side
  Vector3d low, high;
  for (int axis = 0; axis < 3; ++axis) {
    const auto coordinate = [axis](const Piece& piece) { return piece.position[axis]; };
    low[axis] = quantile_of(pieces, kOutside, coordinate);
    high[axis] = quantile_of(pieces, 1.0 - kOutside, coordinate);
  }
  return {low, high};
}

/// Plane across `axis` that has the most surface parallel to it, and its upward side.
struct Level {
  double at;
  int upward;  ///< along the axis: 1, -1, or 0 if undecided
};

/// Returns the side of the levels from `low` to `high` that has more of the visible amount in `box`: 1, -1,
/// or 0 for neither. The amount of a Gaussian is limited to the 90th percentile: in regions that a camera
/// hardly saw, as beneath the ground, a few large Gaussians stand for everything.
int fuller_side(const std::vector<Piece>& pieces, int axis, const Eigen::AlignedBox3d& box, double low,
                double high) {
  constexpr double kUsual = 0.9, kTells = 0.02;  // quantile; fraction of the whole visible amount
  const double most_seen = quantile_of(pieces, kUsual, [](const Piece& piece) { return piece.seen; });
  double above = 0.0, below = 0.0, all = 0.0;
  for (const Piece& piece : pieces) {
    if (!box.contains(piece.position)) continue;
    const double seen = std::min(piece.seen, most_seen);
    all += seen;
    if (piece.position[axis] > high) above += seen;
    if (piece.position[axis] < low) below += seen;
  }
  if (std::abs(above - below) < kTells * all) return 0;
  return above > below ? 1 : -1;
}

/// Finds the level with the most surface along `axis`. Levels with nearly as much count as one with it: both
/// faces of a table top, floor and ceiling.
Level largest_level(const std::vector<Piece>& pieces, int axis, const Eigen::AlignedBox3d& box,
                    const auto& faces) {
  constexpr std::size_t kBins = 64;
  constexpr double kAlike = 0.8;
  std::array<double, kBins> seen{};
  const double low = box.min()[axis], width = box.sizes()[axis] / static_cast<double>(kBins);
  const auto bin = [&](const Piece& piece) -> std::size_t {
    if (width == 0.0) return 0;  // all are in one plane
    const double at = (piece.position[axis] - low) / width;
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(kBins - 1)));
  };
  for (const Piece& piece : pieces)
    if (faces(piece, axis) && box.contains(piece.position)) seen[bin(piece)] += piece.seen;
  const auto most = std::ranges::max_element(seen);
  const auto alike = [&](double one) { return one >= kAlike * *most; };
  const auto middle = [&](auto at) { return low + (static_cast<double>(at - seen.begin()) + 0.5) * width; };
  const double lowest = middle(std::ranges::find_if(seen, alike));
  const double highest = middle(std::find_if(seen.rbegin(), seen.rend(), alike).base() - 1);
  return {middle(most), fuller_side(pieces, axis, box, lowest - width, highest + width)};
}

Proposal<UpAxis> propose_frame(const std::vector<Piece>& pieces, const Eigen::AlignedBox3d& box) {
  // Normals within 15 degrees of an axis, as have 3.4 % of surfaces with random orientations.
  constexpr double kCosine = 0.966, kStandsOut = 0.1, kAhead = 1.5;
  const auto faces = [](const Piece& piece, int axis) {
    return piece.flat && std::abs(piece.normal[axis]) > kCosine;
  };
  std::array<double, 3> seen{};
  double all = 0.0;
  for (const Piece& piece : pieces) {
    if (!box.contains(piece.position)) continue;
    if (piece.flat) all += piece.seen;
    for (int axis = 0; axis < 3; ++axis)
      seen[static_cast<std::size_t>(axis)] += faces(piece, axis) ? piece.seen : 0.0;
  }
  std::array<int, 3> order{0, 1, 2};
  std::ranges::sort(order, [&](int a, int b) { return seen[std::size_t(a)] > seen[std::size_t(b)]; });
  const double first = seen[std::size_t(order[0])], second = seen[std::size_t(order[1])];
  if (!(first > kStandsOut * all) || first < kAhead * second)
    return {UpAxis::kAsIs,
            "no direction has more surface than the others; choose --frame so that it is upright"};
  const Level level = largest_level(pieces, order[0], box, faces);
  const double share = 100.0 * first / all;
  const char axis = kAxes[std::size_t(order[0])];
  if (level.upward == 0)
    return {UpAxis::kAsIs, fmt::format("{:.0f} % of the surface faces along {}, and the up direction is "
                                       "ambiguous; choose --frame so that it is upright",
                                       share, axis)};
  return {
      kUpAxes[std::size_t(order[0])][level.upward > 0 ? 1 : 0],
      fmt::format(
          "{:.0f} % of the surface is parallel to {} = {:.3g}, and most of the scene is on one side of it",
          share, axis, level.at)};
}

Proposal<double> propose_opacity(const std::vector<Piece>& pieces) {
  double all = 0.0;
  for (const Piece& piece : pieces) all += piece.seen;
  double best = kPaperThresholds.front(), kept = 1.0;
  for (const double threshold : kPaperThresholds) {
    double seen = 0.0;
    for (const Piece& piece : pieces) seen += piece.opacity > threshold ? piece.seen : 0.0;
    if (threshold != kPaperThresholds.front() && seen < SceneSetup::kSeenShare * all) break;
    best = threshold;
    kept = all > 0.0 ? seen / all : 0.0;
  }
  return {best, fmt::format("keeps {:.0f} % of the visible surface (opacity times area)", 100.0 * kept)};
}

/// Proposes Tukey's far fence of the logarithms, since sizes span decades; or the limit of giant Gaussians in
/// a scene of this size, if that is less.
Proposal<std::optional<double>> propose_max_scale(const std::vector<Piece>& pieces,
                                                  const Eigen::AlignedBox3d& box, double scale) {
  constexpr double kFar = 3.0, kLeast = 4.0;  // interquartile ranges; least factor, for sizes all alike
  const auto longest = [](const Piece& piece) { return piece.longest; };
  const double low = quantile_of(pieces, 0.25, longest), high = quantile_of(pieces, 0.75, longest);
  const double far = high * std::max(kLeast, std::pow(high / low, kFar));
  const double fence = std::min(far, std::max(kLeast * high, kGiantShare * box.sizes().norm()));
  const auto outliers = std::ranges::count_if(pieces, [&](const Piece& p) { return p.longest > fence; });
  if (outliers == 0) return {std::nullopt, "no Gaussian is far larger than the others"};
  return {scale * fence, fmt::format("{} Gaussians are far larger than the others", outliers)};
}

Proposal<std::optional<Eigen::AlignedBox3d>> propose_crop(const std::vector<Piece>& pieces,
                                                          const Eigen::AlignedBox3d& box,
                                                          const Eigen::Quaterniond& rotation, double scale) {
  constexpr double kGrown = 0.25;  // fraction of its size on each side
  const Vector3d margin = kGrown * box.sizes();
  const Eigen::AlignedBox3d larger(box.min() - margin, box.max() + margin);
  const auto outside =
      std::ranges::count_if(pieces, [&](const Piece& p) { return !larger.contains(p.position); });
  if (outside == 0) return {std::nullopt, "no Gaussian is far from the others"};
  Eigen::AlignedBox3d world;
  for (const auto corner : {Eigen::AlignedBox3d::BottomLeftFloor, Eigen::AlignedBox3d::TopRightCeil})
    world.extend(scale * (rotation * larger.corner(corner)));
  return {world, fmt::format("{} Gaussians are far from the others", outside)};
}

/// Rounds to two significant digits, the accuracy of a proposed scale, and to a double that prints with no
/// more.
double rounded(double scale) {
  const double digits = 1.0 - std::floor(std::log10(scale));
  const double unit = std::pow(10.0, std::abs(digits));
  return digits > 0.0 ? std::round(scale * unit) / unit : std::round(scale / unit) * unit;
}

}  // namespace

SceneSetup propose_setup(const GaussianScene& scene, double tool_radius) {
  const std::vector<Piece> pieces = pieces_of(scene);
  if (pieces.empty()) throw Error("{}: no Gaussian can collide; see palpate info", scene.source);
  const Eigen::AlignedBox3d box = central_box(pieces);
  const double usual = quantile_of(pieces, 0.5, [](const Piece& piece) { return piece.longest; });
  SceneSetup setup;
  setup.frame = propose_frame(pieces, box);
  const double scale = tool_radius / (SceneSetup::kGaussiansAcross * usual);
  setup.scale.value = rounded(scale);
  setup.scale.reason = fmt::format(
      "the median Gaussian is then {:.2g} mm large, a {:g}th of the tool, and the scene {:.2g} m across",
      1e3 * setup.scale.value * usual, SceneSetup::kGaussiansAcross,
      setup.scale.value * box.sizes().maxCoeff());
  setup.opacity_min = propose_opacity(pieces);
  setup.max_scale = propose_max_scale(pieces, box, setup.scale.value);
  setup.crop_box = propose_crop(pieces, box, upright(setup.frame.value), setup.scale.value);
  return setup;
}

}  // namespace palpate

#include <palpate/haptics/part_groups.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Geometry>

namespace palpate {
namespace {

using Parts = std::span<const ToolPart>;
using Members = std::span<std::size_t>;

/// Least cost of the parts of a group, relative to its own: what the group saves near a surface then pays for
/// its cost where the surface meets only the group's solid.
constexpr double kWorth = 1.1;

/// Bounding box of the centres of `members`, in the tool frame.
Eigen::AlignedBox3d box_of(Parts parts, Members members) {
  Eigen::AlignedBox3d box;
  for (const std::size_t k : members) box.extend(parts[k].pose.position);
  return box;
}

/// The Minkowski sum of an ellipsoid with semi-axes a_i and a ball of radius r is inside the ellipsoid with
/// semi-axes b_i^2 = (1 + 1/c) a_i^2 + (1 + c) r^2, for every c > 0; the least volume of several c is taken.
/// A box with half sides h_i is inside the ellipsoid with a_i = sqrt(d) h_i, where d of them are not zero.
ToolPart solid_around(Parts parts, Members members) {
  const Eigen::AlignedBox3d box = box_of(parts, members);
  double radius = 0.0;
  for (const std::size_t k : members) radius = std::max(radius, parts[k].semi_axes.maxCoeff());
  const Eigen::Array3d half = 0.5 * box.sizes().array();
  const Eigen::Array3d squared = static_cast<double>((half > 0.0).count()) * half.square();
  Eigen::Array3d best = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
  constexpr int kTries = 24;
  for (int k = 0; k < kTries; ++k) {
    const double c = 0.0625 * std::pow(1.2, k);  // up to 4
    const Eigen::Array3d tried = (1.0 + 1.0 / c) * squared + (1.0 + c) * radius * radius;
    if (tried.prod() < best.prod()) best = tried;
  }
  return {"group", best.sqrt(), {box.center(), Eigen::Quaterniond::Identity()}};
}

bool is_group(Parts parts, Members members, const ToolPart& solid) {
  double sections = 0.0;
  for (const std::size_t k : members) sections += section(parts[k]);
  return members.size() <= kMostInGroup && kWorth * section(solid) <= sections;
}

/// Halves `members` across the longest side of their box until all parts are groups.
void divide(Parts parts, Members members, std::vector<PartGroup>& groups) {
  if (members.size() == 1) {
    groups.push_back({parts[members[0]], {members[0]}});
    return;
  }
  const ToolPart solid = solid_around(parts, members);
  if (is_group(parts, members, solid)) {
    groups.push_back({solid, {members.begin(), members.end()}});
    return;
  }
  Eigen::Index longest = 0;
  box_of(parts, members).sizes().maxCoeff(&longest);
  std::ranges::stable_sort(members, {}, [&](std::size_t k) { return parts[k].pose.position[longest]; });
  const std::size_t half = members.size() / 2;
  divide(parts, members.first(half), groups);
  divide(parts, members.subspan(half), groups);
}

}  // namespace

double section(const ToolPart& part) { return part.semi_axes.prod() / part.semi_axes.minCoeff(); }

std::vector<PartGroup> group_parts(Parts parts) {
  std::vector<PartGroup> groups;
  if (parts.size() <= kFewParts) {
    for (std::size_t k = 0; k < parts.size(); ++k) groups.push_back({parts[k], {k}});
    return groups;
  }
  std::vector<std::size_t> members(parts.size());
  std::iota(members.begin(), members.end(), std::size_t{0});
  divide(parts, members, groups);
  return groups;
}

}  // namespace palpate

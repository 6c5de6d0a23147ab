// Groups of parts that one search of the scene serves.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/haptics/part_groups.h>
#include <palpate/study/random.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

ToolPart part_at(const Vector3d& position, const Vector3d& semi_axes = {0.012, 0.012, 0.014}) {
  return {"part", semi_axes, {position, Eigen::Quaterniond::Identity()}};
}

/// `side` times `side` parts, `spacing` apart.
std::vector<ToolPart> plate(int side, double spacing) {
  std::vector<ToolPart> parts;
  for (int i = 0; i < side; ++i)
    for (int k = 0; k < side; ++k) parts.push_back(part_at({spacing * i, spacing * k, 0.002 * (i % 2)}));
  return parts;
}

std::vector<std::size_t> members_of(const std::vector<PartGroup>& groups) {
  std::vector<std::size_t> all;
  for (const PartGroup& group : groups) all.insert(all.end(), group.members.begin(), group.members.end());
  std::ranges::sort(all);
  return all;
}

/// True if `solid`, along the axes of the tool, has all of the ball that holds `part`.
bool holds(const ToolPart& solid, const ToolPart& part, Random& random) {
  const double radius = part.semi_axes.maxCoeff();
  for (int k = 0; k < 200; ++k) {
    const Vector3d direction = Vector3d{random.normal(), random.normal(), random.normal()}.normalized();
    const Vector3d from = part.pose.position + radius * direction - solid.pose.position;
    if (from.cwiseQuotient(solid.semi_axes).norm() > 1.0 + 1e-12) return false;
  }
  return true;
}

/// Semi-axes a >= b >= c: pi a b is the largest. Over pi.
double largest_section(const ToolPart& solid) { return solid.semi_axes.prod() / solid.semi_axes.minCoeff(); }

TEST(PartGroups, HaveEachPartOnceAndHoldAllOfIt) {
  Random random(7);
  for (const int side : {5, 9, 16}) {
    const std::vector<ToolPart> parts = plate(side, 0.008);
    const std::vector<PartGroup> groups = group_parts(parts);
    EXPECT_LE(groups.size(), parts.size() / 2) << "neighbours are together";
    const std::vector<std::size_t> members = members_of(groups);
    ASSERT_EQ(members.size(), parts.size());
    for (std::size_t k = 0; k < members.size(); ++k) EXPECT_EQ(members[k], k);
    for (const PartGroup& group : groups) {
      EXPECT_LE(group.members.size(), kMostInGroup);
      if (group.members.size() == 1) continue;
      for (const std::size_t k : group.members) EXPECT_TRUE(holds(group.around, parts[k], random));
    }
  }
}

TEST(PartGroups, CostNoMoreThanTheirParts) {
  for (const double spacing : {0.004, 0.008, 0.012, 0.016, 0.024})
    for (const PartGroup& group : group_parts(plate(9, spacing))) {
      if (group.members.size() == 1) continue;
      EXPECT_LT(largest_section(group.around), group.members.size() * largest_section(part_at({})));
    }
}

// Of a row, the solid is long and of a plate it is flat: it meets no more of the scene than it must.
TEST(PartGroups, AreAsFlatAsWhatTheyHold) {
  const std::vector<ToolPart> parts = plate(9, 0.008);
  for (const PartGroup& group : group_parts(parts)) {
    const double thickness = parts[0].semi_axes.maxCoeff() + 0.001;
    EXPECT_LT(group.around.semi_axes.z(), 1.4 * thickness);
  }
}

// The solid is the least of its family: axes b_i^2 = (1 + 1/c) d h_i^2 + (1 + c) r^2 about a box with half
// sides h_i, d of them not zero, and balls of radius r at its corners.
TEST(PartGroups, AreNoLargerThanTheyMustBe) {
  int checked = 0;
  for (const double spacing : {0.004, 0.008, 0.012}) {
    const std::vector<ToolPart> parts = plate(9, spacing);
    for (const PartGroup& group : group_parts(parts)) {
      if (group.members.size() == 1) continue;
      Eigen::AlignedBox3d box;
      for (const std::size_t k : group.members) box.extend(parts[k].pose.position);
      const Eigen::Array3d sides = box.sizes().array(), h2 = 0.25 * sides.square();
      const auto d = static_cast<double>((sides > 0.0).count());
      const double r2 = std::pow(parts[0].semi_axes.maxCoeff(), 2);
      double least = 1.0;
      for (double c = 0.07; c < 4.0; c *= 1.001)
        least = std::min(least, std::sqrt(((1.0 + 1.0 / c) * d * h2 + (1.0 + c) * r2).prod()));
      EXPECT_LT(group.around.semi_axes.prod(), 1.02 * least);
      ++checked;
    }
  }
  EXPECT_GT(checked, 10);
}

TEST(PartGroups, LeavePartsThatAreFarApartAlone) {
  const std::vector<ToolPart> parts = plate(6, 0.1);
  const std::vector<PartGroup> groups = group_parts(parts);
  ASSERT_EQ(groups.size(), parts.size());
  for (const PartGroup& group : groups) EXPECT_EQ(group.around, parts[group.members.at(0)]);
}

TEST(PartGroups, LeaveTheFewPartsOfAnOrdinaryToolAlone) {
  std::vector<ToolPart> parts = plate(3, 0.001);
  parts.resize(kFewParts);
  EXPECT_EQ(group_parts(parts).size(), parts.size());
}

// All in one place: halving ends though no axis divides them.
TEST(PartGroups, EndWherePartsAreInOnePlace) {
  const std::vector<ToolPart> parts(40, part_at({0.1, 0.2, 0.3}));
  EXPECT_EQ(members_of(group_parts(parts)).size(), parts.size());
}

}  // namespace
}  // namespace palpate

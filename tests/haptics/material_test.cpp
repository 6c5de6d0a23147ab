#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <set>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/haptics/material.h>
#include <support/allocation_guard.h>

namespace palpate {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using test::AllocationGuard;

constexpr float kUnset = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint32_t kLastId = std::numeric_limits<std::uint32_t>::max();

TEST(IdSet, IsTheUnionOfItsRanges) {
  const IdSet set({{10, 20}, {3, 3}, {15, 30}, {31, 31}, {40, 40}, {12, 14}});
  EXPECT_EQ(set.ranges(), (std::vector<IdRange>{{3, 3}, {10, 31}, {40, 40}}));
  for (const std::uint32_t id : {3U, 10U, 20U, 25U, 31U, 40U}) EXPECT_TRUE(set.contains(id)) << id;
  for (const std::uint32_t id : {0U, 2U, 4U, 9U, 32U, 39U, 41U, kLastId})
    EXPECT_FALSE(set.contains(id)) << id;
  EXPECT_FALSE(IdSet({}).contains(0));
}

TEST(IdSet, ReachesTheLastId) {
  const IdSet set({{kLastId, kLastId}, {0, 0}, {kLastId - 1, kLastId}});
  EXPECT_EQ(set.ranges(), (std::vector<IdRange>{{0, 0}, {kLastId - 1, kLastId}}));
  EXPECT_TRUE(set.contains(kLastId));
  EXPECT_FALSE(set.contains(kLastId - 2));
}

TEST(IdSet, AgreesWithASetOfIds) {
  std::mt19937 random(1);
  for (int round = 0; round < 200; ++round) {
    std::set<std::uint32_t> truth;
    std::vector<IdRange> ranges;
    for (std::uint32_t k = random() % 12; k > 0; --k) {
      const std::uint32_t first = random() % 60, last = first + random() % 8;
      ranges.push_back({first, last});
      for (std::uint32_t id = first; id <= last; ++id) truth.insert(id);
    }
    const IdSet set(ranges);
    for (std::uint32_t id = 0; id < 80; ++id) ASSERT_EQ(set.contains(id), truth.contains(id)) << id;
  }
}

TEST(MaterialMap, IsEmptyWithoutAnyProperty) {
  EXPECT_TRUE(MaterialMap().empty());
  EXPECT_EQ(MaterialMap().of(7, Vector3d::Zero()), Material{});
  EXPECT_FALSE(MaterialMap({{MaterialRegion::Everywhere{}, {.friction = 1.0}}}).empty());
  PlyMaterials rows;
  rows.values[kMaterialDamping] = {1.0F};
  EXPECT_FALSE(MaterialMap({}, rows).empty());
}

TEST(MaterialMap, ShapesIncludeTheirSurface) {
  const MaterialMap map({{AlignedBox3d(Vector3d(0, 0, 0), Vector3d(1, 2, 3)), {.friction = 1.0}},
                         {MaterialSphere{{5, 0, 0}, 0.5}, {.friction = 2.0}}});
  const auto friction = [&](const Vector3d& p) { return map.of(0, p).friction.value_or(0.0); };
  EXPECT_EQ(friction({0, 0, 0}), 1.0);
  EXPECT_EQ(friction({1, 2, 3}), 1.0);
  EXPECT_EQ(friction({0.5, 1, 3.001}), 0.0);
  EXPECT_EQ(friction({-0.001, 1, 1}), 0.0);
  EXPECT_EQ(friction({5.5, 0, 0}), 2.0);
  EXPECT_EQ(friction({5.4, 0.4, 0}), 0.0);  // inside the sphere's box only
}

TEST(MaterialMap, TheLastRegionWinsPropertyByProperty) {
  const MaterialMap map({{MaterialRegion::Everywhere{}, {.stiffness = 100.0, .friction = 0.1}},
                         {IdSet({{5, 9}}), {.stiffness = 200.0}},
                         {IdSet({{8, 12}}), {.friction = 0.3}},
                         {IdSet({{9, 9}}), {.stiffness = 400.0, .damping = 4.0}}});
  EXPECT_EQ(map.of(4, Vector3d::Zero()), (Material{100.0, 0.1, {}}));
  EXPECT_EQ(map.of(5, Vector3d::Zero()), (Material{200.0, 0.1, {}}));
  EXPECT_EQ(map.of(8, Vector3d::Zero()), (Material{200.0, 0.3, {}}));
  EXPECT_EQ(map.of(9, Vector3d::Zero()), (Material{400.0, 0.3, 4.0}));
  EXPECT_EQ(map.of(12, Vector3d::Zero()), (Material{100.0, 0.3, {}}));
}

TEST(MaterialMap, RegionsLieOverTheRowsOfTheFile) {
  PlyMaterials rows;
  rows.values[kMaterialStiffness] = {10.0F, 20.0F, kUnset};
  rows.values[kMaterialFriction] = {0.5F, kUnset, kUnset};
  const MaterialMap map({{IdSet({{0, 0}}), {.stiffness = 99.0}}}, rows);
  EXPECT_EQ(map.of(0, Vector3d::Zero()), (Material{99.0, 0.5, {}}));
  EXPECT_EQ(map.of(1, Vector3d::Zero()), (Material{20.0, {}, {}}));
  EXPECT_EQ(map.of(2, Vector3d::Zero()), Material{});
  EXPECT_EQ(map.of(3, Vector3d::Zero()), Material{});  // no such row
}

/// Regions on a grid, so that centres often lie on their surfaces.
class RandomMaterials {
 public:
  explicit RandomMaterials(unsigned seed) : random_(seed) {}

  Vector3d point() {
    const int x = below(7), y = below(7), z = below(7);
    return Vector3d(x, y, z) - Vector3d::Constant(3);
  }

  Material material() {
    Material m;
    if (below(2) != 0) m.stiffness = 1 + below(1000);
    if (below(2) != 0) m.friction = below(10);
    if (below(2) != 0) m.damping = below(100);
    return m;
  }

  MaterialRegion region() {
    const Vector3d a = point(), b = point();
    switch (below(4)) {
      case 0: return {AlignedBox3d(a.cwiseMin(b), a.cwiseMax(b)), material()};
      case 1: return {MaterialSphere{a, static_cast<double>(below(4))}, material()};
      case 2: {
        const auto first = static_cast<std::uint32_t>(below(40));
        return {IdSet({{first, first + static_cast<std::uint32_t>(below(9))}}), material()};
      }
      default: return {MaterialRegion::Everywhere{}, material()};
    }
  }

  std::vector<float> column() {
    std::vector<float> values(static_cast<std::size_t>(below(2) * 40));
    for (float& v : values) v = below(2) != 0 ? static_cast<float>(below(50)) : kUnset;
    return values;
  }

  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }

 private:
  std::mt19937 random_;
};

/// Written from the definition: paint row by row, region over region.
Material painted(const std::vector<MaterialRegion>& regions, const PlyMaterials& rows, std::uint32_t id,
                 const Vector3d& c) {
  std::optional<double> result[kMaterialPropertyCount];
  for (std::size_t p = 0; p < kMaterialPropertyCount; ++p) {
    const auto& column = rows.values[p];
    if (id < column.size() && column[id] == column[id]) result[p] = column[id];
  }
  for (const MaterialRegion& region : regions) {
    bool inside = true;
    if (const auto* box = std::get_if<AlignedBox3d>(&region.shape)) {
      for (int axis = 0; axis < 3; ++axis)
        inside = inside && c[axis] >= box->min()[axis] && c[axis] <= box->max()[axis];
    } else if (const auto* sphere = std::get_if<MaterialSphere>(&region.shape)) {
      inside = (c - sphere->center).norm() <= sphere->radius;
    } else if (const auto* ids = std::get_if<IdSet>(&region.shape)) {
      inside = false;
      for (const IdRange& r : ids->ranges()) inside = inside || (id >= r.first && id <= r.last);
    }
    if (!inside) continue;
    if (region.material.stiffness) result[0] = region.material.stiffness;
    if (region.material.friction) result[1] = region.material.friction;
    if (region.material.damping) result[2] = region.material.damping;
  }
  return {result[0], result[1], result[2]};
}

TEST(MaterialMap, AgreesWithPaintingRegionOverRegion) {
  RandomMaterials random(2);
  for (int round = 0; round < 300; ++round) {
    std::vector<MaterialRegion> regions;
    for (int k = random.below(8); k > 0; --k) regions.push_back(random.region());
    PlyMaterials rows;
    for (auto& column : rows.values) column = random.column();
    const MaterialMap map(regions, rows);
    for (std::uint32_t id = 0; id < 50; ++id) {
      const Vector3d center = random.point();
      ASSERT_EQ(map.of(id, center), painted(regions, rows, id, center)) << "round " << round << ", id " << id;
    }
  }
}

TEST(MaterialMap, TakesNothingFromTheHeap) {
  RandomMaterials random(3);
  std::vector<MaterialRegion> regions;
  for (int k = 0; k < 50; ++k) regions.push_back(random.region());
  PlyMaterials rows;
  rows.values[kMaterialFriction] = random.column();
  const MaterialMap map(regions, rows);
  const AllocationGuard guard;
  for (std::uint32_t id = 0; id < 100; ++id) map.of(id, Vector3d::Zero());
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace palpate

#include <palpate/study/still_life.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/study/random.h>
#include <palpate/study/still_life_parts.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using still_life::Thing;

constexpr double kLeastSpacing = 0.001, kMostSpacing = 0.02;  // Unit: [m].
constexpr int kGrapes = 38;
constexpr int kTries = 5;  // positions tried for a grape

/// Objects in their places, and the space that they occupy.
class Arrangement {
 public:
  explicit Arrangement(double spacing) : spacing_(spacing) {}

  void add(Thing thing) {
    for (Occluder& occluder : thing.room) {
      occluder.object = static_cast<int>(things_.size());
      light_.add(occluder);
    }
    things_.push_back(std::move(thing));
  }
  /// Position at which a ball comes to rest that is lowered at (x, y).
  Vector3d rest(double x, double y, double radius) const {
    return {x, y, still_life::rest_height(light_, x, y, radius)};
  }
  /// Position to which it rolls from there: no position beside it is lower.
  Vector3d rolled(Vector3d place, double radius) const {
    constexpr int kRolls = 60, kWays = 8;
    constexpr double kRoll = 0.0025, kLower = 1e-4;  // Unit: [m].
    for (int roll = 0; roll < kRolls; ++roll) {
      Vector3d lowest = place;
      for (int way = 0; way < kWays; ++way) {
        const double angle = 2.0 * std::numbers::pi * way / kWays;
        const Vector3d next =
            rest(place.x() + kRoll * std::cos(angle), place.y() + kRoll * std::sin(angle), radius);
        if (next.z() < lowest.z()) lowest = next;
      }
      if (lowest.z() > place.z() - kLower) break;
      place = lowest;
    }
    return place;
  }
  double spacing() const { return spacing_; }
  const SoftLight& light() const { return light_; }
  const std::vector<Thing>& things() const { return things_; }

 private:
  double spacing_;
  SoftLight light_;
  std::vector<Thing> things_;
};

/// Draws a unit vector tilted from +z, by a slope of up to `share` in x and in y.
Vector3d leaning(Random& random, double share) {
  const double x = random.uniform(-share, share), y = random.uniform(-share, share);
  return Vector3d(x, y, 1.0).normalized();
}

void add_fruit_in_bowl(Arrangement& all, Random& random) {
  const Vector3d& bowl = still_life::bowl_place();
  const double h = all.spacing();
  const auto beside = [&](double angle, double off, double radius) {
    return all.rest(bowl.x() + off * std::cos(angle), bowl.y() + off * std::sin(angle), radius);
  };
  const double turn = random.uniform(-0.15, 0.15);
  all.add(still_life::make_orange(h, beside(turn - 0.35, 0.063, 0.0385), 0.0385, {0.5, -0.7, 0.6}, 101));
  all.add(still_life::make_apple(h, beside(turn + 1.25, 0.064, 0.0395), 0.0395, leaning(random, 0.5),
                                 0xd9b23a, 0xb3201a, 102));
  all.add(still_life::make_orange(h, beside(turn + 2.85, 0.064, 0.0375), 0.0375, leaning(random, 0.8), 103));
  all.add(still_life::make_apple(h, beside(turn + 4.25, 0.062, 0.0390), 0.0390, {-0.25, -0.55, 0.8}, 0xa9bf3f,
                                 0xc8a53a, 104));
  all.add(still_life::make_apple(h, beside(turn + 0.9, 0.004, 0.0400), 0.0400, {0.25, -0.35, 0.9}, 0xcf8f2e,
                                 0xa3161a, 105));
}

/// Adds grapes one by one, each on top of what is there.
void add_grapes(Arrangement& all, Random& random) {
  const Vector3d& bowl = still_life::bowl_place();
  const Vector3d middle = bowl + Vector3d(0.092, -0.112, 0.0);
  for (int k = 0; k < kGrapes; ++k) {
    const double radius = random.uniform(0.0098, 0.0118);
    const double spread = 0.010 + 0.022 * static_cast<double>(k) / kGrapes;
    Vector3d best(0.0, 0.0, std::numeric_limits<double>::infinity());
    for (int t = 0; t < kTries; ++t) {
      const double x = middle.x() + spread * random.normal(), y = middle.y() + spread * random.normal();
      const Vector3d place = all.rolled(all.rest(x, y, radius), radius);
      // Low positions near the middle of the bunch are preferred.
      const double worth = place.z() + 0.5 * (place - middle).head<2>().norm();
      if (worth < best.z() + 0.5 * (best - middle).head<2>().norm()) best = place;
    }
    all.add(still_life::make_grape(all.spacing(), best, radius, 200U + static_cast<std::uint32_t>(k)));
  }
}

void add_fruit_on_table(Arrangement& all, Random& random) {
  const double h = all.spacing();
  all.add(still_life::make_pear(h, all.rest(0.145, -0.035, 0.0365), 0.0375, leaning(random, 0.08), 301));
  all.add(still_life::make_lemon(h, all.rest(0.225, -0.115, 0.0275), 0.0285, {0.9, 0.45, 0.1}, 302));
  all.add(still_life::make_apple(h, all.rest(0.315, -0.02, 0.0365), 0.0385, {-0.3, -0.25, 0.9}, 0xd8a63a,
                                 0xb01c1c, 303));
}

/// Adds a cairn, and pebbles in front of it. Stones are sunk in a little: their centres are lower than half
/// their thickness above what they lie on.
void add_stones(Arrangement& all) {
  const double h = all.spacing();
  const double x = -0.355, y = -0.105;
  all.add(still_life::make_stone(h, {x, y, 0.0205}, {0.058, 0.047, 0.022}, 0.4, 0.03, 0x77736c, 401));
  all.add(still_life::make_stone(h, {x + 0.004, y - 0.003, 0.0575}, {0.045, 0.036, 0.0165}, 1.3, -0.05,
                                 0x8d7f6e, 411));
  all.add(still_life::make_stone(h, {x - 0.002, y + 0.002, 0.0860}, {0.031, 0.026, 0.0135}, 2.2, 0.06,
                                 0x5c6066, 421));
  all.add(
      still_life::make_stone(h, {x + 0.001, y, 0.1075}, {0.019, 0.016, 0.0095}, 0.3, 0.05, 0x9a8f80, 431));
  all.add(
      still_life::make_stone(h, {-0.315, -0.215, 0.0155}, {0.034, 0.026, 0.0165}, 0.9, 0.05, 0x6a5c52, 441));
  all.add(
      still_life::make_stone(h, {-0.385, -0.225, 0.0115}, {0.024, 0.021, 0.0125}, 0.1, -0.06, 0x9c9a92, 451));
}

Arrangement arranged(std::uint64_t seed, double spacing) {
  Random random(seed);
  Arrangement all(spacing);
  all.add(still_life::make_table(spacing));
  all.add(still_life::make_cloth(spacing));
  all.add(still_life::make_bowl(spacing));
  all.add(still_life::make_log(spacing));
  all.add(still_life::make_plate(spacing));
  add_stones(all);
  add_fruit_in_bowl(all, random);
  add_grapes(all, random);
  add_fruit_on_table(all, random);
  return all;
}

}  // namespace

StillLife make_still_life(std::uint64_t seed, double spacing) {
  if (!(spacing >= kLeastSpacing && spacing <= kMostSpacing))
    throw Error("spacing {} m: must be {} m to {} m for a still life", spacing, kLeastSpacing, kMostSpacing);
  const Arrangement all = arranged(seed, spacing);
  StillLife result;
  GaussianScene& scene = result.scene;
  scene.source = fmt::format("{}, spacing {} m, seed {}", kStillLife, spacing, seed);
  scene.format = "procedural";
  Random random(seed);
  for (const Thing& thing : all.things()) {
    const auto first = static_cast<std::uint32_t>(scene.size());
    const int object = static_cast<int>(result.objects.size());
    for (const PaintedPatch& patch : thing.patches) append_patch(patch, all.light(), object, random, scene);
    if (scene.size() == first) throw Error("{}: no Gaussians remain; use a smaller spacing", thing.name);
    const IdRange ids{first, static_cast<std::uint32_t>(scene.size()) - 1U};
    result.objects.push_back({thing.name, ids, thing.material, thing.shape, thing.pose, thing.relief});
  }
  return result;
}

std::vector<MaterialRegion> material_regions(const StillLife& still_life) {
  std::vector<MaterialRegion> regions;
  for (const StillLifeObject& object : still_life.objects)
    regions.push_back({IdSet({object.ids}), object.material});
  return regions;
}

PlyMaterials material_columns(const StillLife& still_life) {
  constexpr float kUnset = std::numeric_limits<float>::quiet_NaN();
  PlyMaterials columns;
  for (auto& column : columns.values) column.assign(still_life.scene.size(), kUnset);
  for (const StillLifeObject& object : still_life.objects) {
    const std::array<std::optional<double>, kMaterialPropertyCount> values{
        object.material.stiffness, object.material.friction, object.material.damping};
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (!values[k]) continue;
      std::fill(columns.values[k].begin() + object.ids.first, columns.values[k].begin() + object.ids.last + 1,
                static_cast<float>(*values[k]));
    }
  }
  return columns;
}

}  // namespace palpate

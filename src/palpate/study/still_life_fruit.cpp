#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include <palpate/geometry/rotation.h>
#include <palpate/study/solid_noise.h>
#include <palpate/study/still_life_parts.h>

namespace palpate::still_life {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

/// A body of revolution about its local z axis, with a relief.
struct Fruit {
  Vector3d center;
  Eigen::Quaterniond turn;
  double radius;
  std::function<double(double polar)> profile;          ///< radius at an angle from the stalk, in radii
  std::function<double(const Vector3d& local)> relief;  ///< over the unit direction. Unit: [m].

  Vector3d local(double u, double v) const {
    const double polar = pi * (1.0 - v), around = 2.0 * pi * u;
    return {std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar)};
  }
  Vector3d at(double u, double v) const {
    const Vector3d direction = local(u, v);
    const double r = radius * profile(pi * (1.0 - v)) + relief(direction);
    return center + turn * (r * direction);
  }
};

PaintedPatch skin(const Fruit& fruit, double spacing, const std::function<Paint(const Vector3d&)>& paint) {
  return {[fruit](double u, double v) { return fruit.at(u, v); },
          [fruit, paint](double u, double v, const Vector3d&) { return paint(fruit.local(u, v)); }, spacing};
}

Occluder ball(const Vector3d& center, double radius) {
  return {center, radius, [center, radius](const Vector3d& p) { return (p - center).norm() - radius; }, 0};
}

/// A thin bent tube from `from` along `up`.
PaintedPatch stalk(const Vector3d& from, const Vector3d& up, double length, double radius, double spacing) {
  const Vector3d side = up.unitOrthogonal();
  const Vector3d other = up.cross(side);
  return {[=](double u, double v) -> Vector3d {
            const double around = 2.0 * pi * u;
            const double r =
                radius * (1.0 + 0.5 * smooth(0.75, 1.0, v)) * std::sqrt(std::min(1.0, 12.0 * (1.0 - v)));
            const Vector3d axis = from + length * v * up + 0.35 * length * v * v * side;
            return axis + r * (std::cos(around) * side + std::sin(around) * other);
          },
          [](double, double v, const Vector3d& p) {
            const double grain = solid_noise(900.0 * p, 5);
            return Paint{mixed(linear_color(0x6b4a2a), linear_color(0x3a2a18), smooth(0.2, 1.0, v)) *
                             (1.0 + 0.25 * grain),
                         0.0};
          },
          spacing};
}

Eigen::Quaterniond towards(const Vector3d& up) { return rotation_between(Vector3d::UnitZ(), up); }

}  // namespace

Thing make_orange(double spacing, const Vector3d& center, double radius, const Vector3d& up,
                  std::uint32_t seed) {
  constexpr double kPits = 0.0005;  // Unit: [m].
  Fruit fruit{center, towards(up), radius, [](double) { return 1.0; }, {}};
  const auto pits = [=](const Vector3d& d) { return std::min(0.0, ridged_noise(9.0 * d, 2, seed) + 0.15); };
  const auto navel = [](const Vector3d& d) { return smooth(0.965, 0.995, d.z()); };
  fruit.relief = [=](const Vector3d& d) { return kPits * (1.6 * pits(d)) - 0.0012 * navel(d); };
  Thing thing{"orange", {700.0, 0.5, std::nullopt}, {}, {ball(center, radius)}};
  thing.patches.push_back(skin(fruit, 0.62 * spacing, [=](const Vector3d& d) {
    const double patchy = fractal_noise(3.0 * d, 3, seed + 9U);
    Vector3d albedo = mixed(linear_color(0xe8720c), linear_color(0xf29a1f), 0.5 + 0.5 * patchy);
    albedo *= 1.0 + 0.35 * pits(d);
    albedo = mixed(albedo, linear_color(0x4f5a1c), navel(d));
    return Paint{albedo, 0.22};
  }));
  thing.shape = make_sphere(radius);
  thing.pose = {center, fruit.turn};
  thing.relief = 0.0026;
  return thing;
}

Thing make_apple(double spacing, const Vector3d& center, double radius, const Vector3d& up, unsigned rgb,
                 unsigned blush, std::uint32_t seed) {
  const Fruit fruit{center, towards(up), radius,
                    [](double polar) {
                      const double top = std::exp(-polar * polar / 0.14);
                      const double low = pi - polar;
                      const double bottom = std::exp(-low * low / 0.09);
                      return 1.0 - 0.36 * top - 0.16 * bottom - 0.05 * (1.0 - std::cos(polar)) * 0.5;
                    },
                    [=](const Vector3d& d) {
                      const double lobes = std::cos(5.0 * std::atan2(d.y(), d.x()));
                      return radius *
                             (0.012 * lobes * smooth(0.0, 1.0, -d.z()) + 0.012 * solid_noise(2.0 * d, seed));
                    }};
  Thing thing{"apple", {1100.0, 0.2, std::nullopt}, {}, {ball(center, 0.97 * radius)}};
  thing.patches.push_back(skin(fruit, 0.72 * spacing, [=](const Vector3d& d) {
    const double around = std::atan2(d.y(), d.x());
    const Vector3d streaky(7.0 * std::cos(around), 7.0 * std::sin(around), 1.2 * d.z());
    const double side = 0.5 + 0.9 * fractal_noise(1.3 * d + Vector3d(4.0, 0.0, 0.0), 2, seed);
    const double red = smooth(0.15, 0.75, side + 0.35 * fractal_noise(streaky, 3, seed + 3U));
    Vector3d albedo = mixed(linear_color(rgb), linear_color(blush), red);
    albedo = mixed(albedo, linear_color(0x8a8a3a), smooth(0.93, 0.99, d.z()));
    if (solid_noise(22.0 * d, seed + 5U) > 0.72) albedo = mixed(albedo, linear_color(0xe8d9a0), 0.45);
    return Paint{albedo, 0.75};
  }));
  const Vector3d axis = fruit.turn * Vector3d::UnitZ();
  thing.patches.push_back(stalk(center + 0.62 * radius * axis, axis, 0.021, 0.0014, 0.4 * spacing));
  thing.shape = make_sphere(radius);
  thing.pose = {center, fruit.turn};
  thing.relief = 0.4 * radius;
  return thing;
}

Thing make_pear(double spacing, const Vector3d& center, double radius, const Vector3d& up,
                std::uint32_t seed) {
  const Fruit fruit{center, towards(up), radius,
                    [](double polar) {
                      const double low = pi - polar;
                      return 1.0 + 1.02 * std::exp(-polar * polar / 0.22) - 0.1 * std::exp(-low * low / 0.05);
                    },
                    [=](const Vector3d& d) { return radius * 0.03 * solid_noise(2.2 * d, seed); }};
  const Vector3d axis = fruit.turn * Vector3d::UnitZ();
  Thing thing{"pear",
              {800.0, 0.4, std::nullopt},
              {},
              {ball(center, 0.98 * radius), ball(center + 1.3 * radius * axis, 0.42 * radius)}};
  thing.patches.push_back(skin(fruit, 0.72 * spacing, [=](const Vector3d& d) {
    const double patchy = 0.5 + 0.6 * fractal_noise(2.0 * d, 3, seed + 2U);
    Vector3d albedo = mixed(linear_color(0x9db23c), linear_color(0xd9c64e), patchy);
    albedo = mixed(albedo, linear_color(0xc4622c), 0.6 * smooth(0.2, 1.0, d.x() + 0.4 * patchy));
    const double russet = smooth(0.25, 0.6, fractal_noise(14.0 * d, 3, seed + 7U));
    return Paint{mixed(albedo, linear_color(0x8a6a30), 0.55 * russet), 0.3};
  }));
  thing.patches.push_back(stalk(center + 1.96 * radius * axis, axis, 0.02, 0.0015, 0.4 * spacing));
  return thing;
}

Thing make_lemon(double spacing, const Vector3d& center, double radius, const Vector3d& up,
                 std::uint32_t seed) {
  const auto pits = [=](const Vector3d& d) { return std::min(0.0, ridged_noise(8.0 * d, 2, seed) + 0.1); };
  const Fruit fruit{center, towards(up), radius,
                    [](double polar) {
                      const double c = std::abs(std::cos(polar));
                      const double end = std::exp(-std::pow(std::min(polar, pi - polar), 2.0) / 0.05);
                      return 0.96 + 0.22 * c * c * c + 0.16 * end;
                    },
                    [=](const Vector3d& d) { return 0.0009 * pits(d); }};
  Thing thing{"lemon", {650.0, 0.55, std::nullopt}, {}, {ball(center, 0.97 * radius)}};
  thing.patches.push_back(skin(fruit, 0.66 * spacing, [=](const Vector3d& d) {
    const double patchy = 0.5 + 0.5 * fractal_noise(2.5 * d, 3, seed + 2U);
    const Vector3d albedo =
        mixed(linear_color(0xe8c414), linear_color(0xf6de4a), patchy) * (1.0 + 0.3 * pits(d));
    return Paint{mixed(albedo, linear_color(0x8f9a30), smooth(0.93, 1.0, std::abs(d.z()))), 0.25};
  }));
  thing.shape = make_sphere(radius);
  thing.pose = {center, fruit.turn};
  thing.relief = 0.4 * radius;
  return thing;
}

Thing make_grape(double spacing, const Vector3d& center, double radius, std::uint32_t seed) {
  const Fruit fruit{center, towards(Vector3d(0.2, 0.1, 1.0)), radius, [](double) { return 1.0; },
                    [](const Vector3d&) { return 0.0; }};
  Thing thing{"grape", {300.0, 0.3, 1.0}, {}, {ball(center, radius)}};
  thing.patches.push_back(skin(fruit, 0.66 * spacing, [=](const Vector3d& d) {
    const double bloom = smooth(0.0, 0.7, 0.35 * d.z() + fractal_noise(2.5 * d, 3, seed));
    const double hue = 0.5 + 0.5 * solid_noise(0.9 * d, seed + 4U);
    const Vector3d albedo = mixed(linear_color(0x431836), linear_color(0x2c1f4a), hue);
    return Paint{mixed(albedo, linear_color(0x7f7c9c), 0.5 * bloom), 0.7 * (1.0 - 0.6 * bloom)};
  }));
  thing.shape = make_sphere(radius);
  thing.pose = {center, fruit.turn};
  thing.relief = 1e-5;
  return thing;
}

}  // namespace palpate::still_life

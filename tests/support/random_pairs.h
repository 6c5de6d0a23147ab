/// \file
/// Random ellipsoids for the tests of the overlap test.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <palpate/geometry/ellipsoid.h>
#include <support/k_oracle.h>

namespace palpate::test {

/// Everything random in these tests comes from one of these, seeded with a literal. Each number is drawn in a
/// statement or a braced list of its own: the order of arguments and operands is the compiler's choice.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine_); }
  double normal() { return std::normal_distribution<double>()(engine_); }
  Eigen::Vector3d in_box(double half) {
    return {uniform(-half, half), uniform(-half, half), uniform(-half, half)};
  }
  Eigen::Vector3d direction() {
    for (;;) {
      const Eigen::Vector3d v{normal(), normal(), normal()};
      if (v.norm() > 1e-3) return v.normalized();
    }
  }
  Eigen::Quaterniond rotation() {
    return Eigen::Quaterniond(Eigen::Vector4d{normal(), normal(), normal(), normal()}.normalized());
  }
  /// Semi-axes drawn apart, log-uniformly.
  Eigen::Vector3d semi_axes(double low, double high) {
    return {log_uniform(low, high), log_uniform(low, high), log_uniform(low, high)};
  }
  /// A vector of any direction, its length uniform.
  Eigen::Vector3d vector(double shortest, double longest) {
    const double length = uniform(shortest, longest);
    return length * direction();
  }
  /// An ellipsoid turned any way, its centre in a box, its semi-axes drawn apart.
  Ellipsoid ellipsoid(double half, double low, double high) {
    const Pose pose{in_box(half), rotation()};
    return Ellipsoid::from_semi_axes(pose, semi_axes(low, high));
  }
  /// `size` or its negative.
  double either_sign(double size) { return integer(0, 1) != 0 ? size : -size; }

 private:
  std::mt19937_64 engine_;
};

/// A rotation, up to a factor in [0.7, 1.5], whose columns are orthogonal without any rounding: the integer
/// matrix of an integer quaternion, times a power of two.
inline Eigen::Matrix3d exact_rotation(Random& random) {
  for (;;) {
    const int w = random.integer(-9, 9), x = random.integer(-9, 9), y = random.integer(-9, 9),
              z = random.integer(-9, 9);
    const int n = w * w + x * x + y * y + z * z;
    if (n == 0) continue;
    Eigen::Matrix3d m;
    m << w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y),  //
        2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x),   //
        2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z;
    return std::ldexp(1.0, -static_cast<int>(std::lround(std::log2(n)))) * m;
  }
}

/// An ellipsoid whose axes are orthogonal without any rounding, and of about the lengths given.
inline Ellipsoid exact_ellipsoid(Random& random, const Eigen::Vector3d& center,
                                 const Eigen::Vector3d& semi_axes) {
  // 32-bit lengths times 9-bit integers are doubles without rounding.
  return {center, exact_rotation(random) * semi_axes.cast<float>().cast<double>().asDiagonal()};
}

/// `gaussian`, moved along the line through the two centres so that K_min with `tool` becomes
/// `k_min` (up to the rounding of its centre): 1 - K_min goes with the square of the distance.
inline Ellipsoid moved_to_k_min(const Ellipsoid& tool, Ellipsoid gaussian, double k_min) {
  const long double f = 1 - PairOracle<long double>(tool, gaussian).minimize().k_min;
  const auto scale = static_cast<double>(std::sqrt((1 - static_cast<long double>(k_min)) / f));
  gaussian.center = tool.center - scale * (tool.center - gaussian.center);
  return gaussian;
}

}  // namespace palpate::test

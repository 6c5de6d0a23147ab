#include <palpate/study/solid_noise.h>

#include <cmath>

namespace palpate {
namespace {

using Eigen::Vector3d;

/// Mixes the bits of a lattice point (the finaliser of MurmurHash3).
std::uint32_t mixed(std::uint32_t h) {
  h ^= h >> 16U;
  h *= 0x85ebca6bU;
  h ^= h >> 13U;
  h *= 0xc2b2ae35U;
  return h ^ (h >> 16U);
}

/// Value of a lattice point, in [-1, 1].
double lattice_value(std::int64_t x, std::int64_t y, std::int64_t z, std::uint32_t seed) {
  constexpr double kHalfRange = 0x1p31;
  std::uint32_t h = seed;
  for (const std::int64_t k : {x, y, z}) h = mixed(h ^ (static_cast<std::uint32_t>(k) * 0x9e3779b9U));
  return static_cast<double>(h) / kHalfRange - 1.0;
}

/// Rises from 0 to 1, with first and second derivatives of zero at both ends.
double eased(double t) { return t * t * t * (t * (6.0 * t - 15.0) + 10.0); }

double mix(double a, double b, double share) { return a + share * (b - a); }

template <typename Shaped>
double octaves_of(Vector3d p, int octaves, std::uint32_t seed, const Shaped& shaped) {
  double sum = 0.0, height = 1.0, total = 0.0;
  for (int k = 0; k < octaves; ++k) {
    sum += height * shaped(solid_noise(p, seed + static_cast<std::uint32_t>(k)));
    total += height;
    height *= 0.5;
    p *= 2.0;
  }
  return sum / total;
}

}  // namespace

double solid_noise(const Vector3d& p, std::uint32_t seed) {
  const Vector3d low = p.array().floor();
  const auto x = static_cast<std::int64_t>(low[0]);
  const auto y = static_cast<std::int64_t>(low[1]);
  const auto z = static_cast<std::int64_t>(low[2]);
  const double u = eased(p[0] - low[0]), v = eased(p[1] - low[1]), w = eased(p[2] - low[2]);
  const auto along_x = [&](std::int64_t j, std::int64_t k) {
    return mix(lattice_value(x, j, k, seed), lattice_value(x + 1, j, k, seed), u);
  };
  const auto across_y = [&](std::int64_t k) { return mix(along_x(y, k), along_x(y + 1, k), v); };
  return mix(across_y(z), across_y(z + 1), w);
}

double fractal_noise(const Vector3d& p, int octaves, std::uint32_t seed) {
  return octaves_of(p, octaves, seed, [](double n) { return n; });
}

double ridged_noise(const Vector3d& p, int octaves, std::uint32_t seed) {
  return octaves_of(p, octaves, seed, [](double n) { return 1.0 - 2.0 * std::abs(n); });
}

}  // namespace palpate

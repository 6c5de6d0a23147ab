/// \file
/// Procedural 3D noise for surfaces and colours, identical on every platform.
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace palpate {

/// Value noise (Perlin 1985, on a lattice of hashed values): continuous with its first two derivatives, in
/// [-1, 1], of about one period a unit. Uses sums, products and integer hashes only.
double solid_noise(const Eigen::Vector3d& p, std::uint32_t seed);

/// Returns a sum of `octaves` of solid_noise(), each of half the period and half the amplitude of the
/// previous one, in [-1, 1].
double fractal_noise(const Eigen::Vector3d& p, int octaves, std::uint32_t seed);

/// As fractal_noise(), of 1 - 2 |noise|: sharp crests and round valleys, in [-1, 1].
double ridged_noise(const Eigen::Vector3d& p, int octaves, std::uint32_t seed);

}  // namespace palpate

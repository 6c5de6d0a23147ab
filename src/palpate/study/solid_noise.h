/// \file
/// Noise in space, for surfaces and colours that look grown: the same on every platform.
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace palpate {

/// Value noise (Perlin 1985, on a lattice of hashed values): continuous with its first two derivatives, in
/// [-1, 1], of about one period a unit. Made of sums, products and integer hashes alone.
double solid_noise(const Eigen::Vector3d& p, std::uint32_t seed);

/// A sum of `octaves` of it, each of half the size and half the height of the one before, in [-1, 1].
double fractal_noise(const Eigen::Vector3d& p, int octaves, std::uint32_t seed);

/// The same of 1 - 2 |noise|: sharp crests and round valleys, in [-1, 1].
double ridged_noise(const Eigen::Vector3d& p, int octaves, std::uint32_t seed);

}  // namespace palpate

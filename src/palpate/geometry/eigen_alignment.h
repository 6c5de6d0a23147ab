/// \file
/// Keeps objects from being linked that lay Eigen's types out differently.
#pragma once

#include <Eigen/Core>

#define PALPATE_EIGEN_ALIGNMENT_NAME(bytes) eigen_max_static_align_bytes_is_##bytes
#define PALPATE_EIGEN_ALIGNMENT(bytes) PALPATE_EIGEN_ALIGNMENT_NAME(bytes)

namespace palpate::internal {

/// The library defines this for the alignment that it has been compiled with, and no other. Objects compiled
/// with -mavx or -march=native, and without what the package's CMake targets define, align to 32 bytes or
/// more: without this they would be linked, and read poses where the library has not put them.
extern const char PALPATE_EIGEN_ALIGNMENT(EIGEN_MAX_STATIC_ALIGN_BYTES);
[[gnu::used]] static const char* const kEigenAlignment =
    &PALPATE_EIGEN_ALIGNMENT(EIGEN_MAX_STATIC_ALIGN_BYTES);

}  // namespace palpate::internal

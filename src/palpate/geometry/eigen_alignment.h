/// \file
/// Link-time check that all objects use the same Eigen alignment.
#pragma once

#include <Eigen/Core>

#define PALPATE_EIGEN_ALIGNMENT_NAME(bytes) eigen_max_static_align_bytes_is_##bytes
#define PALPATE_EIGEN_ALIGNMENT(bytes) PALPATE_EIGEN_ALIGNMENT_NAME(bytes)

namespace palpate::internal {

/// The library defines this symbol for the alignment that it was compiled with, and no other. Objects
/// compiled with -mavx or -march=native, without the definitions of the package's CMake targets, align to 32
/// bytes or more: without this check they would link, and read poses at offsets other than the library's.
extern const char PALPATE_EIGEN_ALIGNMENT(EIGEN_MAX_STATIC_ALIGN_BYTES);
[[gnu::used]] static const char* const kEigenAlignment =
    &PALPATE_EIGEN_ALIGNMENT(EIGEN_MAX_STATIC_ALIGN_BYTES);

}  // namespace palpate::internal

#include <palpate/geometry/eigen_alignment.h>

namespace palpate::internal {

const char PALPATE_EIGEN_ALIGNMENT(EIGEN_MAX_STATIC_ALIGN_BYTES) = 0;

}  // namespace palpate::internal

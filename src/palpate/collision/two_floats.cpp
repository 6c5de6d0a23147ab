#include <palpate/collision/two_floats.h>

namespace palpate {

void split(double value, float& high, float& low) {
  high = static_cast<float>(value);
  low = static_cast<float>(value - static_cast<double>(high));
}

}  // namespace palpate

/// \file
/// A double as the sum of two floats.
#pragma once

namespace palpate {

/// value = high + low, to 2^-48 of it. In a source of its own, because GCC 12 where it vectorises takes
/// double(float(x)) for x, and low for 0.
void split(double value, float& high, float& low);

}  // namespace palpate

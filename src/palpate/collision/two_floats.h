/// \file
/// Split of a double into the sum of two floats.
#pragma once

namespace palpate {

/// value = high + low, to a relative 2^-48. In its own source file, because GCC 12, when it vectorises,
/// replaces double(float(x)) by x, and low by 0.
void split(double value, float& high, float& low);

}  // namespace palpate

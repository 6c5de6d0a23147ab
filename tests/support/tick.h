/// \file
/// How often a loop of haptics runs.
#pragma once

namespace palpate::test {

/// Of a loop at 1 kHz. Unit: [s].
inline constexpr double kTick = 1e-3;

}  // namespace palpate::test

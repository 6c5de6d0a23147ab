/// \file
/// Message time stamps.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>

#include "ros_messages.h"

namespace palpate::ros2 {

/// System time, which ROS nodes use unless time is simulated. Unit: [s] since 1970.
inline double now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// Range of stamps. Unit: [s] since 1970.
inline constexpr std::int32_t kLastSecond = std::numeric_limits<std::int32_t>::max();

/// \param seconds since 1970; a double resolves a quarter of a microsecond. Outside [0, kLastSecond): 0, no
/// stamp
inline builtin_interfaces_msg_dds__Time_ time_of(double seconds) {
  if (!(seconds >= 0.0 && seconds < kLastSecond)) return {0, 0U};
  const double whole = std::floor(seconds);
  const auto nanoseconds = static_cast<std::uint32_t>(std::lround((seconds - whole) * 1e9));
  const bool carries = nanoseconds >= 1000000000U;
  return {static_cast<std::int32_t>(whole) + (carries ? 1 : 0), carries ? 0U : nanoseconds};
}

/// Returns NaN for a stamp that is invalid, or that time_of() does not return.
inline double seconds_of(const builtin_interfaces_msg_dds__Time_& time) {
  const bool valid = time.sec >= 0 && time.sec < kLastSecond && time.nanosec < 1000000000U;
  return valid ? time.sec + 1e-9 * time.nanosec : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace palpate::ros2

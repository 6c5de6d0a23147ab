/// \file
/// Message time stamps.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>

#include "ros_messages.h"

namespace palpate::ros2 {

/// System time, which ROS nodes use unless time is simulated. Unit: [s] since 1970.
inline double now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// \param seconds since 1970; a double resolves a quarter of a microsecond
inline builtin_interfaces_msg_dds__Time_ time_of(double seconds) {
  const double whole = std::floor(seconds);
  const auto nanoseconds = static_cast<std::uint32_t>(std::lround((seconds - whole) * 1e9));
  const bool carries = nanoseconds >= 1000000000U;
  return {static_cast<std::int32_t>(whole) + (carries ? 1 : 0), carries ? 0U : nanoseconds};
}

inline double seconds_of(const builtin_interfaces_msg_dds__Time_& time) {
  return time.sec + 1e-9 * time.nanosec;
}

}  // namespace palpate::ros2

/// \file
/// Captured axis that points up.
#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <string_view>

#include <Eigen/Geometry>

#include <palpate/geometry/similarity.h>

namespace palpate {

/// Captured axis that points up and becomes world +z. Of all scene formats, only glTF declares it.
enum class UpAxis : std::uint8_t { kAsIs, kXDown, kXUp, kYDown, kYUp, kZDown, kZUp };

/// Names in files and protocols, in the order of the enumeration.
inline constexpr std::array<std::string_view, 7> kUpAxisNames{"as-is", "x-down", "x-up", "y-down",
                                                              "y-up",  "z-down", "z-up"};
constexpr std::string_view to_string(UpAxis axis) { return kUpAxisNames[static_cast<std::size_t>(axis)]; }

/// Rotation from the captured frame that turns this axis to world +z.
inline Eigen::Quaterniond upright(UpAxis axis) {
  using Eigen::AngleAxisd;
  using Eigen::Quaterniond;
  using Eigen::Vector3d;
  constexpr double kQuarter = std::numbers::pi / 2;
  switch (axis) {
    case UpAxis::kXDown: return Quaterniond(AngleAxisd(kQuarter, Vector3d::UnitY()));
    case UpAxis::kXUp: return Quaterniond(AngleAxisd(-kQuarter, Vector3d::UnitY()));
    case UpAxis::kYDown: return Quaterniond(AngleAxisd(-kQuarter, Vector3d::UnitX()));
    case UpAxis::kYUp: return Quaterniond(AngleAxisd(kQuarter, Vector3d::UnitX()));
    case UpAxis::kZDown: return {0, 1, 0, 0};
    default: return Quaterniond::Identity();
  }
}

/// `registration` with the capture turned upright first.
inline Similarity upright(UpAxis axis, Similarity registration) {
  registration.rotation = registration.rotation * upright(axis);
  return registration;
}

}  // namespace palpate

/// \file
/// Markers of ellipsoids and arrows: visualization_msgs/Marker as plain data, independent of the transport.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <palpate/geometry/ellipsoid.h>
#include <palpate/geometry/pose.h>

namespace palpate {

/// RGB and opacity, each in [0, 1].
struct Color {
  double r, g, b, a;
};

/// One marker; replaces a previous one of the same namespace and id. Members from `type` to `points` apply to
/// kAdd only.
struct Marker {
  enum class Action : std::uint8_t { kAdd = 0, kDelete = 2, kDeleteAll = 3 };
  enum class Type : std::uint8_t { kArrow = 0, kSphere = 2 };

  std::string ns;
  std::uint32_t id = 0;
  Action action = Action::kAdd;
  Type type = Type::kSphere;
  Pose pose = {};
  Eigen::Vector3d scale = Eigen::Vector3d::Zero();  ///< diameters; of an arrow: shaft, head. Unit: [m].
  Color color{};
  std::vector<Eigen::Vector3d> points = {};  ///< of an arrow: from, to. Unit: [m].
};

Marker ellipsoid_marker(const std::string& ns, std::uint32_t id, const Ellipsoid& ellipsoid,
                        const Color& color);
/// \param thickness of its shaft. Unit: [m].
Marker arrow_marker(const std::string& ns, std::uint32_t id, const Eigen::Vector3d& from,
                    const Eigen::Vector3d& to, double thickness, const Color& color);
Marker deleted_marker(const std::string& ns, std::uint32_t id);
/// Returns a marker that deletes all markers.
Marker all_deleted_marker();

}  // namespace palpate

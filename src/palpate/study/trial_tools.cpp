#include <palpate/study/trial_tools.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <palpate/study/evaluation_hand.h>

namespace palpate {
namespace {

constexpr std::array<std::string_view, 8> kToolNames{"ball20", "ball10", "ball5", "ball2",
                                                     "rod",    "needle", "disc",  "plate"};

}  // namespace

std::span<const std::string_view> trial_tools() { return kToolNames; }

std::optional<Tool> trial_tool(std::string_view name) {
  if (name == "ball20") return Tool({0.02, 0.02, 0.02});
  if (name == "ball10") return Tool({0.01, 0.01, 0.01});
  if (name == "ball5") return Tool({0.005, 0.005, 0.005});
  if (name == "ball2") return Tool({0.002, 0.002, 0.002});
  if (name == "rod") return Tool({0.1, 0.003, 0.003});
  if (name == "needle") return Tool({0.005, 0.005, 0.1});
  if (name == "disc") return Tool({0.03, 0.03, 0.005});
  if (name == "plate") return Tool({0.1, 0.1, 0.01});
  return {};
}

Tool turned(const Tool& tool, const Eigen::Quaterniond& turn) {
  std::vector<ToolPart> parts(tool.parts().begin(), tool.parts().end());
  for (ToolPart& part : parts) part.pose = Pose{Eigen::Vector3d::Zero(), turn} * part.pose;
  return Tool(std::move(parts));
}

std::vector<Eigen::Vector3d> front_of(const Tool& tool, const Eigen::Vector3d& along, double spacing) {
  constexpr double kFewest = 200.0, kMost = 12000.0, kP = 1.6;  // surface of an ellipsoid (Thomsen 2004)
  std::vector<Eigen::Vector3d> points;
  for (const ToolPart& part : tool.parts()) {
    const Ellipsoid solid = part.at({});
    const Eigen::Vector3d& a = part.semi_axes;
    const double ab = std::pow(a[0] * a[1], kP), bc = std::pow(a[1] * a[2], kP),
                 ca = std::pow(a[2] * a[0], kP);
    const double area = 4.0 * std::numbers::pi * std::pow((ab + bc + ca) / 3.0, 1.0 / kP);
    const int count = static_cast<int>(std::clamp(2.0 * area / (spacing * spacing), kFewest, kMost));
    for (int k = 0; k < count; ++k) {
      const Eigen::Vector3d u = even_direction(k, count);
      if (u.dot(solid.axes.inverse() * along) > 0.0) points.emplace_back(solid.center + solid.axes * u);
    }
  }
  return points;
}

}  // namespace palpate

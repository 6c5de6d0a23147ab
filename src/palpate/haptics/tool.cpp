#include <palpate/haptics/tool.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace palpate {

Tool::Tool(const Eigen::Vector3d& semi_axes) : parts_{{"tool", semi_axes}} {}

Tool::Tool(std::vector<ToolPart> parts) : parts_(std::move(parts)) {}

double Tool::thinnest() const {
  double least = std::numeric_limits<double>::infinity();
  for (const ToolPart& part : parts_) least = std::min(least, part.semi_axes.minCoeff());
  return least;
}

double Tool::longest() const {
  double most = 0.0;
  for (const ToolPart& part : parts_) most = std::max(most, part.semi_axes.maxCoeff());
  return most;
}

double Tool::radius() const {
  double most = 0.0;
  for (const ToolPart& part : parts_)
    most = std::max(most, part.pose.position.norm() + part.semi_axes.maxCoeff());
  return most;
}

double Tool::gyration() const {
  // The moments of inertia of a solid ellipsoid are m (b^2 + c^2) / 5; a third of their sum is the mean over
  // all axes, and an offset r adds m 2 r^2 / 3.
  double volume = 0.0, moment = 0.0;
  for (const ToolPart& part : parts_) {
    const double m = part.semi_axes.prod();
    volume += m;
    moment += m * (2.0 / 15.0 * part.semi_axes.squaredNorm() + 2.0 / 3.0 * part.pose.position.squaredNorm());
  }
  return std::sqrt(moment / volume);
}

double Tool::support(const Eigen::Vector3d& n) const {
  double most = -std::numeric_limits<double>::infinity();
  for (const ToolPart& part : parts_) {
    const Ellipsoid solid = part.at({});
    most = std::max(most, solid.center.dot(n) + solid.support(n));
  }
  return most;
}

}  // namespace palpate

#include <palpate/gateway/contact_markers.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate {
namespace {

/// Colour of a contact by K_min, from 0 (first touch) to 1: dark to bright, with evenly increasing lightness.
Color color_of(double k_min) {
  constexpr std::array<std::array<double, 3>, 5> kSteps{
      {{0.35, 0.07, 0.43}, {0.63, 0.15, 0.42}, {0.87, 0.29, 0.29}, {0.97, 0.54, 0.14}, {0.96, 0.87, 0.40}}};
  const double at = std::clamp(k_min, 0.0, 1.0) * (kSteps.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), kSteps.size() - 2);
  const double share = at - static_cast<double>(i);
  const auto mix = [&](std::size_t c) { return (1.0 - share) * kSteps[i][c] + share * kSteps[i + 1][c]; };
  return {mix(0), mix(1), mix(2), 0.9};
}

/// Muted colours of the hands, repeated for further hands.
constexpr std::array<Color, 6> kHandColors{{{0.40, 0.52, 0.70, 0.35},
                                            {0.45, 0.62, 0.48, 0.35},
                                            {0.70, 0.55, 0.40, 0.35},
                                            {0.60, 0.45, 0.65, 0.35},
                                            {0.62, 0.60, 0.38, 0.35},
                                            {0.45, 0.60, 0.62, 0.35}}};
constexpr Color kToolColor{0.04, 0.34, 0.77, 0.35};
constexpr Color kNormalColor{0.1, 0.14, 0.19, 0.9};
/// Shaft diameter of an arrow. Unit: [m].
constexpr double kThickness = 5e-4;

std::vector<Marker> part_markers(const std::string& ns, const Color& color, const Tool& tool,
                                 const Pose& pose) {
  std::vector<Marker> markers;
  for (const ToolPart& part : tool.parts())
    markers.push_back(ellipsoid_marker(ns, static_cast<std::uint32_t>(markers.size()), part.at(pose), color));
  return markers;
}

/// Keeps one contact per id, the deepest if several parts of the tool touch it; of these at most `most`, the
/// deepest.
void choose(std::vector<Contact>& contacts, std::size_t most) {
  std::sort(contacts.begin(), contacts.end(), [](const Contact& a, const Contact& b) {
    return a.id != b.id ? a.id < b.id : a.depth > b.depth;
  });
  const auto same = [](const Contact& a, const Contact& b) { return a.id == b.id; };
  contacts.erase(std::unique(contacts.begin(), contacts.end(), same), contacts.end());
  if (contacts.size() <= most) return;
  std::nth_element(contacts.begin(), contacts.begin() + static_cast<std::ptrdiff_t>(most), contacts.end(),
                   [](const Contact& a, const Contact& b) { return a.depth > b.depth; });
  contacts.resize(most);
}

}  // namespace

const std::vector<Marker>& ContactMarkers::next(std::vector<Contact>& contacts,
                                                const EllipsoidLookup& ellipsoids) {
  choose(contacts, kMost);
  ++count_;
  markers_.clear();
  for (const Contact& c : contacts) {
    Ellipsoid ellipsoid = ellipsoids.at(c.id);
    ellipsoid.center = c.center;
    markers_.push_back(ellipsoid_marker("contacts", c.id, ellipsoid, color_of(c.k_min)));
    markers_.push_back(
        arrow_marker("normals", c.id, c.point, c.point + c.depth * c.normal, kThickness, kNormalColor));
    seen_[c.id] = count_;
  }
  for (auto seen = seen_.begin(); seen != seen_.end();) {
    if (seen->second != count_) {
      for (const char* ns : {"contacts", "normals"}) markers_.push_back(deleted_marker(ns, seen->first));
    }
    seen = count_ - seen->second >= kReach ? seen_.erase(seen) : std::next(seen);
  }
  return markers_;
}

std::vector<Marker> tool_markers(const Tool& tool, const Pose& pose) {
  return part_markers("tool", kToolColor, tool, pose);
}

std::vector<Marker> hand_markers(const std::string& name, std::size_t number, const Tool& tool,
                                 const TickRecord& tick) {
  Color color = kHandColors[number % kHandColors.size()];
  std::vector<Marker> markers = part_markers(name, color, tool, tick.tool);
  color.a = 0.9;
  const Eigen::Vector3d& from = tick.tool.position;
  markers.push_back(
      arrow_marker(name + "/force", 0, from, from + kForceArrow * tick.sent_world.force, kThickness, color));
  return markers;
}

}  // namespace palpate

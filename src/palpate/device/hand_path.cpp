#include <palpate/device/hand_path.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace palpate {
namespace {

/// Two tones per axis of physiological tremor, in no simple ratio: no repetition within a run. Unit: [Hz].
constexpr std::array<std::array<double, 2>, 3> kTremor{{{8.3, 11.1}, {9.1, 11.9}, {8.7, 10.3}}};

}  // namespace

HandPath to_and_fro(Trajectory trajectory) {
  return [path = std::move(trajectory)](double t) {
    const double first = path.front().t, length = path.back().t - first;
    if (length == 0.0) return path.front().pose;
    const double way = std::fmod(std::max(0.0, t), 2.0 * length);
    return pose_at(path, first + (way <= length ? way : 2.0 * length - way));
  };
}

HandPath with_tremor(HandPath path, double amplitude) {
  return [path = std::move(path), amplitude](double t) {
    Pose pose = path(t);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const double f : kTremor[axis])
        pose.position[static_cast<Eigen::Index>(axis)] +=
            0.5 * amplitude * std::sin(2.0 * std::numbers::pi * f * t);
    }
    return pose;
  };
}

}  // namespace palpate

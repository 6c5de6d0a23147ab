#include <palpate/record/trajectory.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include <fmt/ranges.h>

#include <palpate/base/csv.h>
#include <palpate/base/error.h>
#include <palpate/geometry/unit_quaternion.h>
#include <palpate/scene/gaussian_scene.h>

namespace palpate {
namespace {

// Bounds that no hand exceeds, but a damaged file may; within them every velocity is finite.
constexpr double kMaxTime = 1e12;      // s
constexpr double kMinTimeStep = 1e-9;  // s
constexpr double kMaxDeviation = 0.1;  // of a quaternion's norm from 1; more is no rounding error

constexpr std::array<std::string_view, 11> kColumns{"t",  "x",  "y",   "z",   "qw", "qx",
                                                    "qy", "qz", "ufx", "ufy", "ufz"};

/// Refuses a table of something else.
void require_poses(const CsvHeader& header) {
  std::vector<std::string_view> missing;
  for (const std::string_view name : std::span(kColumns).first(4)) {
    if (!header.has(name)) missing.push_back(name);
  }
  if (missing.empty()) return;
  throw Error(
      "{}: line {}: is no trajectory: column{} '{}' {} missing; t,x,y,z in s and m are needed, and may "
      "be followed by qw,qx,qy,qz",
      header.source, header.line, missing.size() > 1 ? "s" : "", fmt::join(missing, "', '"),
      missing.size() > 1 ? "are" : "is");
}

Eigen::Quaterniond orientation_of(const CsvTable& table, std::size_t row,
                                  const std::array<std::size_t, 4>& columns) {
  const Eigen::Quaterniond q(table.at(row, columns[0]), table.at(row, columns[1]), table.at(row, columns[2]),
                             table.at(row, columns[3]));
  if (!(std::abs(q.norm() - 1.0) <= kMaxDeviation)) {
    throw Error("{}: line {}: the quaternion qw,qx,qy,qz has norm {}; it must be 1", table.source,
                table.lines[row], q.norm());
  }
  return normalized_once(q);
}

}  // namespace

Pose pose_at(const Trajectory& trajectory, double t) {
  const auto after = std::upper_bound(trajectory.begin(), trajectory.end(), t,
                                      [](double time, const TimedPose& p) { return time < p.t; });
  if (after == trajectory.begin()) return trajectory.front().pose;
  if (after == trajectory.end()) return trajectory.back().pose;
  const TimedPose& a = *(after - 1);
  const TimedPose& b = *after;
  const double share = (t - a.t) / (b.t - a.t);
  return {a.pose.position + share * (b.pose.position - a.pose.position),
          a.pose.orientation.slerp(share, b.pose.orientation)};
}

Trajectory read_trajectory(const std::string& path) {
  CsvReader reader(path);
  require_poses(reader.header());
  reader.ignore_all_but(kColumns);
  const CsvTable table = read_csv(reader);
  const std::array<std::size_t, 4> txyz{table.column("t"), table.column("x"), table.column("y"),
                                        table.column("z")};
  const bool oriented = table.has("qw") || table.has("qx") || table.has("qy") || table.has("qz");
  std::array<std::size_t, 4> q{};
  if (oriented) q = {table.column("qw"), table.column("qx"), table.column("qy"), table.column("qz")};
  const bool felt = table.has("ufx");
  std::array<std::size_t, 3> f{};
  if (felt) f = {table.column("ufx"), table.column("ufy"), table.column("ufz")};
  if (table.rows() == 0) throw Error("{}: has no poses; at least one row is needed", path);

  Trajectory trajectory;
  trajectory.reserve(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    TimedPose timed;
    timed.t = table.at(row, txyz[0]);
    timed.pose.position = {table.at(row, txyz[1]), table.at(row, txyz[2]), table.at(row, txyz[3])};
    if (oriented) timed.pose.orientation = orientation_of(table, row, q);
    if (felt)
      timed.user_force = Eigen::Vector3d(table.at(row, f[0]), table.at(row, f[1]), table.at(row, f[2]));
    if (!trajectory.empty() && !(timed.t > trajectory.back().t)) {
      throw Error("{}: line {}: column 't': {} does not follow {}; rows must be in order of time", path,
                  table.lines[row], timed.t, trajectory.back().t);
    }
    if (!trajectory.empty() && timed.t - trajectory.back().t < kMinTimeStep) {
      throw Error("{}: line {}: column 't': {} follows {} by less than a nanosecond; seconds are needed",
                  path, table.lines[row], timed.t, trajectory.back().t);
    }
    if (std::abs(timed.t) > kMaxTime || timed.pose.position.cwiseAbs().maxCoeff() > kMaxExtent) {
      throw Error(
          "{}: line {}: columns 't' to 'z': a time or position beyond 1e12; seconds and metres are needed",
          path, table.lines[row]);
    }
    trajectory.push_back(timed);
  }
  return trajectory;
}

void write_trajectory(const Trajectory& trajectory, const std::string& path, const std::string& made) {
  std::string text = csv_comment(made) + "t,x,y,z,qw,qx,qy,qz\n";
  for (const TimedPose& timed : trajectory) {
    const auto& p = timed.pose.position;
    const auto& q = timed.pose.orientation;
    append_csv_row(text, std::array{timed.t, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()});
  }
  write_file(path, text);
}

}  // namespace palpate

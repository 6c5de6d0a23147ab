#include <palpate/record/run_columns.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <type_traits>

#include <palpate/base/csv.h>

namespace palpate {
namespace {

using enum ColumnGroup;

/// \param field a lambda without captures that gives the place of the value in a row.
template <typename Field>
constexpr RunColumn column(ColumnGroup group, std::string_view name, Field, int digits = 7) {
  const auto get = [](const RunRow& row) { return static_cast<double>(Field{}(row)); };
  const auto set = [](RunRow& row, double value) {
    auto& place = Field{}(row);
    place = static_cast<std::remove_reference_t<decltype(place)>>(value);
  };
  return {name, group, get, set, digits};
}

template <typename Field>
constexpr RunColumn whole(ColumnGroup group, std::string_view name, Field field, std::string_view what,
                          double most) {
  RunColumn made = column(group, name, field);
  made.whole_number = what;
  made.most = most;
  return made;
}

/// Added once there were recordings.
constexpr RunColumn later(RunColumn made) {
  made.may_lack = true;
  return made;
}

template <typename Field>
constexpr RunColumn count(std::string_view name, Field field) {
  return whole(kAlways, name, field, "a count", 4294967295.0);
}

const Eigen::Vector3d& user(const RunRow& row) {
  static const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  return row.user_force ? *row.user_force : none;
}
Eigen::Vector3d& user(RunRow& row) {
  return row.user_force ? *row.user_force : row.user_force.emplace(Eigen::Vector3d::Zero());
}

// A line a column.
// clang-format off
const LiveColumns& live(const RunRow& row) {
  static const LiveColumns none;
  return row.live ? *row.live : none;
}
LiveColumns& live(RunRow& row) { return row.live ? *row.live : row.live.emplace(); }

constexpr auto kLastState = static_cast<double>(GovernorState::kStopped);
constexpr auto kLastFault = static_cast<double>(kFaultCount - 1);

constexpr std::array kColumns{
    column(kAlways, "t", [](auto& r) -> auto& { return r.t; }, 12),
    column(kAlways, "x", [](auto& r) -> auto& { return r.tool.position.x(); }),
    column(kAlways, "y", [](auto& r) -> auto& { return r.tool.position.y(); }),
    column(kAlways, "z", [](auto& r) -> auto& { return r.tool.position.z(); }),
    column(kAlways, "qw", [](auto& r) -> auto& { return r.tool.orientation.w(); }),
    column(kAlways, "qx", [](auto& r) -> auto& { return r.tool.orientation.x(); }),
    column(kAlways, "qy", [](auto& r) -> auto& { return r.tool.orientation.y(); }),
    column(kAlways, "qz", [](auto& r) -> auto& { return r.tool.orientation.z(); }),
    count("candidates", [](auto& r) -> auto& { return r.candidates; }),
    count("filtered", [](auto& r) -> auto& { return r.filtered; }),
    count("colliding", [](auto& r) -> auto& { return r.colliding; }),
    column(kAlways, "k_max", [](auto& r) -> auto& { return r.k_max; }),
    column(kAlways, "fx", [](auto& r) -> auto& { return r.wrench.force.x(); }),
    column(kAlways, "fy", [](auto& r) -> auto& { return r.wrench.force.y(); }),
    column(kAlways, "fz", [](auto& r) -> auto& { return r.wrench.force.z(); }),
    column(kAlways, "tx", [](auto& r) -> auto& { return r.wrench.torque.x(); }),
    column(kAlways, "ty", [](auto& r) -> auto& { return r.wrench.torque.y(); }),
    column(kAlways, "tz", [](auto& r) -> auto& { return r.wrench.torque.z(); }),
    column(kAlways, "px", [](auto& r) -> auto& { return r.proxy.x(); }),
    column(kAlways, "py", [](auto& r) -> auto& { return r.proxy.y(); }),
    column(kAlways, "pz", [](auto& r) -> auto& { return r.proxy.z(); }),
    column(kAlways, "compute_us", [](auto& r) -> auto& { return r.compute_us; }, 4),
    column(kUserForce, "ufx", [](auto& r) -> auto& { return user(r).x(); }),
    column(kUserForce, "ufy", [](auto& r) -> auto& { return user(r).y(); }),
    column(kUserForce, "ufz", [](auto& r) -> auto& { return user(r).z(); }),
    column(kLive, "vx", [](auto& r) -> auto& { return live(r).velocity.linear.x(); }),
    column(kLive, "vy", [](auto& r) -> auto& { return live(r).velocity.linear.y(); }),
    column(kLive, "vz", [](auto& r) -> auto& { return live(r).velocity.linear.z(); }),
    column(kLive, "wx", [](auto& r) -> auto& { return live(r).velocity.angular.x(); }, 0),
    column(kLive, "wy", [](auto& r) -> auto& { return live(r).velocity.angular.y(); }, 0),
    column(kLive, "wz", [](auto& r) -> auto& { return live(r).velocity.angular.z(); }, 0),
    column(kLive, "sfx", [](auto& r) -> auto& { return live(r).sent.force.x(); }),
    column(kLive, "sfy", [](auto& r) -> auto& { return live(r).sent.force.y(); }),
    column(kLive, "sfz", [](auto& r) -> auto& { return live(r).sent.force.z(); }),
    later(column(kLive, "stx", [](auto& r) -> auto& { return live(r).sent.torque.x(); }, 0)),
    later(column(kLive, "sty", [](auto& r) -> auto& { return live(r).sent.torque.y(); }, 0)),
    later(column(kLive, "stz", [](auto& r) -> auto& { return live(r).sent.torque.z(); }, 0)),
    whole(kLive, "state", [](auto& r) -> auto& { return live(r).state; }, "a state", kLastState),
    whole(kLive, "fault", [](auto& r) -> auto& { return live(r).fault; }, "a fault", kLastFault),
    column(kLive, "energy", [](auto& r) -> auto& { return live(r).energy; }),
    column(kLive, "stored", [](auto& r) -> auto& { return live(r).stored; }),
    column(kLive, "damping", [](auto& r) -> auto& { return live(r).damping; }, 0),
    column(kLive, "margin", [](auto& r) -> auto& { return live(r).margin; }, 0),
    column(kLive, "age_us", [](auto& r) -> auto& { return live(r).age_us; }, 4),
};
// clang-format on

}  // namespace

bool RunColumn::takes(double value) const {
  return whole_number.empty() || (value >= 0.0 && value <= most && value == std::floor(value));
}

RunGroups RunGroups::of(const RunRow& row) {
  return {.user_force = row.user_force.has_value(), .live = row.live.has_value()};
}

bool RunGroups::has(ColumnGroup group) const {
  switch (group) {
    case kAlways: return true;
    case kUserForce: return user_force;
    case kLive: return live;
  }
  return false;
}

std::span<const RunColumn> run_columns() { return kColumns; }

std::vector<RunColumn> run_columns(const RunGroups& groups) {
  std::vector<RunColumn> columns;
  std::copy_if(kColumns.begin(), kColumns.end(), std::back_inserter(columns),
               [&](const RunColumn& column) { return groups.has(column.group); });
  return columns;
}

std::string run_header(std::span<const RunColumn> columns) {
  std::string line;
  for (const RunColumn& column : columns) {
    if (!line.empty()) line += ',';
    line += column.name;
  }
  return line + '\n';
}

void append_run_row(std::string& out, const RunRow& row, std::span<const RunColumn> columns) {
  std::array<double, kColumns.size()> values{};
  for (std::size_t k = 0; k < columns.size(); ++k) values[k] = columns[k].get(row);
  append_csv_row(out, std::span(values).first(columns.size()));
}

}  // namespace palpate

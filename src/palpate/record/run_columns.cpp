#include <palpate/record/run_columns.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <type_traits>

#include <fmt/format.h>

namespace palpate {
namespace {

using enum ColumnGroup;

/// \param field a captureless lambda that returns a reference to the value in a row.
template <typename Field>
constexpr RunColumn column(ColumnGroup group, std::string_view name, std::string_view unit,
                           std::string_view help, Field, int digits = 7) {
  const auto get = [](const RunRow& row) { return static_cast<double>(Field{}(row)); };
  const auto set = [](RunRow& row, double value) {
    auto& place = Field{}(row);
    place = static_cast<std::remove_reference_t<decltype(place)>>(value);
  };
  return {name, unit, help, group, get, set, digits};
}

template <typename Field>
constexpr RunColumn count(std::string_view name, std::string_view unit, std::string_view help, Field field) {
  RunColumn made = column(kAlways, name, unit, help, field);
  made.whole_number = "a count";
  made.most = 4294967295.0;
  return made;
}

/// Returns the column with integers that files write as one of `words`.
RunColumn worded(RunColumn made, std::string_view what, std::span<const std::string_view> words) {
  made.whole_number = what;
  made.most = static_cast<double>(words.size() - 1);
  made.words = words;
  return made;
}

/// Marks a column that recordings of earlier versions lack.
constexpr RunColumn later(RunColumn made) {
  made.may_lack = true;
  return made;
}

const Eigen::Vector3d& user(const RunRow& row) {
  static const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  return row.user_force ? *row.user_force : none;
}
Eigen::Vector3d& user(RunRow& row) {
  return row.user_force ? *row.user_force : row.user_force.emplace(Eigen::Vector3d::Zero());
}

// One line per column.
// clang-format off
const LiveColumns& live(const RunRow& row) {
  static const LiveColumns none;
  return row.live ? *row.live : none;
}
LiveColumns& live(RunRow& row) { return row.live ? *row.live : row.live.emplace(); }

constexpr std::size_t kStateCount = static_cast<std::size_t>(GovernorState::kStopped) + 1;

/// Names of the governor's states, by to_string().
std::span<const std::string_view> state_words() {
  static const auto words = [] {
    std::array<std::string_view, kStateCount> all;
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = to_string(static_cast<GovernorState>(k));
    return all;
  }();
  return words;
}

std::span<const std::string_view> fault_words() {
  static const auto words = [] {
    std::array<std::string_view, kFaultCount> all;
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = traits(static_cast<Fault>(k)).name;
    return all;
  }();
  return words;
}

const auto& columns() {
  static const std::array all{
    column(kAlways, "t", "s", "time on the run's clock", [](auto& r) -> auto& { return r.t; }, 12),
    column(kAlways, "x", "m", "position of the tool centre, x component, world frame", [](auto& r) -> auto& { return r.tool.position.x(); }),
    column(kAlways, "y", "m", "position of the tool centre, y component, world frame", [](auto& r) -> auto& { return r.tool.position.y(); }),
    column(kAlways, "z", "m", "position of the tool centre, z component, world frame", [](auto& r) -> auto& { return r.tool.position.z(); }),
    column(kAlways, "qw", "1", "orientation of the tool, unit quaternion, w component, world frame", [](auto& r) -> auto& { return r.tool.orientation.w(); }),
    column(kAlways, "qx", "1", "orientation of the tool, unit quaternion, x component, world frame", [](auto& r) -> auto& { return r.tool.orientation.x(); }),
    column(kAlways, "qy", "1", "orientation of the tool, unit quaternion, y component, world frame", [](auto& r) -> auto& { return r.tool.orientation.y(); }),
    column(kAlways, "qz", "1", "orientation of the tool, unit quaternion, z component, world frame", [](auto& r) -> auto& { return r.tool.orientation.z(); }),
    count("candidates", "1", "Gaussians after the broad phase", [](auto& r) -> auto& { return r.candidates; }),
    count("filtered", "1", "candidates after the bounding-sphere test (paper eq. 4)", [](auto& r) -> auto& { return r.filtered; }),
    count("colliding", "1", "filtered Gaussians that overlap the tool", [](auto& r) -> auto& { return r.colliding; }),
    column(kAlways, "k_max", "1", "largest K_min of the contacts (paper eq. 6); 0 without contact", [](auto& r) -> auto& { return r.k_max; }),
    column(kAlways, "fx", "N", "force of the model on the tool, x component, world frame", [](auto& r) -> auto& { return r.wrench.force.x(); }),
    column(kAlways, "fy", "N", "force of the model on the tool, y component, world frame", [](auto& r) -> auto& { return r.wrench.force.y(); }),
    column(kAlways, "fz", "N", "force of the model on the tool, z component, world frame", [](auto& r) -> auto& { return r.wrench.force.z(); }),
    column(kAlways, "tx", "N m", "torque of the model about the tool centre, x component, world frame", [](auto& r) -> auto& { return r.wrench.torque.x(); }),
    column(kAlways, "ty", "N m", "torque of the model about the tool centre, y component, world frame", [](auto& r) -> auto& { return r.wrench.torque.y(); }),
    column(kAlways, "tz", "N m", "torque of the model about the tool centre, z component, world frame", [](auto& r) -> auto& { return r.wrench.torque.z(); }),
    column(kAlways, "px", "m", "position of the proxy, x component, world frame; the tool centre if the model has no proxy", [](auto& r) -> auto& { return r.proxy.x(); }),
    column(kAlways, "py", "m", "position of the proxy, y component, world frame; the tool centre if the model has no proxy", [](auto& r) -> auto& { return r.proxy.y(); }),
    column(kAlways, "pz", "m", "position of the proxy, z component, world frame; the tool centre if the model has no proxy", [](auto& r) -> auto& { return r.proxy.z(); }),
    column(kAlways, "compute_us", "us", "computation time of contacts and force", [](auto& r) -> auto& { return r.compute_us; }, 4),
    column(kUserForce, "ufx", "N", "force of the user, measured at the handle, x component, world frame", [](auto& r) -> auto& { return user(r).x(); }),
    column(kUserForce, "ufy", "N", "force of the user, measured at the handle, y component, world frame", [](auto& r) -> auto& { return user(r).y(); }),
    column(kUserForce, "ufz", "N", "force of the user, measured at the handle, z component, world frame", [](auto& r) -> auto& { return user(r).z(); }),
    column(kLive, "vx", "m/s", "velocity of the tool centre, x component, world frame", [](auto& r) -> auto& { return live(r).velocity.linear.x(); }),
    column(kLive, "vy", "m/s", "velocity of the tool centre, y component, world frame", [](auto& r) -> auto& { return live(r).velocity.linear.y(); }),
    column(kLive, "vz", "m/s", "velocity of the tool centre, z component, world frame", [](auto& r) -> auto& { return live(r).velocity.linear.z(); }),
    column(kLive, "wx", "rad/s", "angular velocity of the tool, x component, world frame", [](auto& r) -> auto& { return live(r).velocity.angular.x(); }, 0),
    column(kLive, "wy", "rad/s", "angular velocity of the tool, y component, world frame", [](auto& r) -> auto& { return live(r).velocity.angular.y(); }, 0),
    column(kLive, "wz", "rad/s", "angular velocity of the tool, z component, world frame", [](auto& r) -> auto& { return live(r).velocity.angular.z(); }, 0),
    column(kLive, "sfx", "N", "force sent to the motors after the safety governor, x component, world axes", [](auto& r) -> auto& { return live(r).sent.force.x(); }),
    column(kLive, "sfy", "N", "force sent to the motors after the safety governor, y component, world axes", [](auto& r) -> auto& { return live(r).sent.force.y(); }),
    column(kLive, "sfz", "N", "force sent to the motors after the safety governor, z component, world axes", [](auto& r) -> auto& { return live(r).sent.force.z(); }),
    later(column(kLive, "stx", "N m", "torque sent to the motors after the safety governor, x component, world axes", [](auto& r) -> auto& { return live(r).sent.torque.x(); }, 0)),
    later(column(kLive, "sty", "N m", "torque sent to the motors after the safety governor, y component, world axes", [](auto& r) -> auto& { return live(r).sent.torque.y(); }, 0)),
    later(column(kLive, "stz", "N m", "torque sent to the motors after the safety governor, z component, world axes", [](auto& r) -> auto& { return live(r).sent.torque.z(); }, 0)),
    worded(column(kLive, "state", "word", "state of the safety governor", [](auto& r) -> auto& { return live(r).state; }), "a state", state_words()),
    worded(column(kLive, "fault", "word", "fault that withholds the force", [](auto& r) -> auto& { return live(r).fault; }), "a fault", fault_words()),
    column(kLive, "energy", "J", "net energy put into the hand", [](auto& r) -> auto& { return live(r).energy; }),
    column(kLive, "stored", "J", "energy of the model's spring; 0 if the model has no potential", [](auto& r) -> auto& { return live(r).stored_energy; }),
    column(kLive, "damping", "N s/m", "damping added by the passivity controller", [](auto& r) -> auto& { return live(r).damping; }, 0),
    column(kLive, "margin", "1", "stiffness margin: largest passive stiffness over set stiffness; 0 if unknown", [](auto& r) -> auto& { return live(r).margin; }, 0),
    column(kLive, "age_us", "us", "age of the device reading when its force is sent", [](auto& r) -> auto& { return live(r).age_us; }, 4),
  };
  return all;
}
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

std::span<const RunColumn> run_columns() { return columns(); }

std::vector<RunColumn> run_columns(const RunGroups& groups) {
  std::vector<RunColumn> those;
  std::copy_if(columns().begin(), columns().end(), std::back_inserter(those),
               [&](const RunColumn& column) { return groups.has(column.group); });
  return those;
}

void take_run_words(CsvReader& reader) {
  for (const RunColumn& column : run_columns()) {
    if (!column.words.empty() && reader.header().has(column.name))
      reader.take_words(reader.header().column(column.name), column.words);
  }
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
  const char* separator = "";
  for (const RunColumn& column : columns) {
    const double value = column.get(row);
    out += separator;
    if (column.words.empty()) {
      fmt::format_to(std::back_inserter(out), "{}", value);
    } else {
      out += column.words[static_cast<std::size_t>(value)];
    }
    separator = ",";
  }
  out += '\n';
}

}  // namespace palpate

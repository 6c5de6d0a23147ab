#include <palpate/haptics/tool_file.h>

#include <utility>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/base/toml_file.h>
#include <palpate/geometry/unit_quaternion.h>

namespace palpate {
namespace {

Eigen::Quaterniond orientation_of(const TomlValue& value) {
  const auto q = value.numbers<4>();
  const Eigen::Quaterniond orientation(q[0], q[1], q[2], q[3]);
  if (!(orientation.norm() > 1e-6 && orientation.norm() < 1e6))
    throw value.must_be("a quaternion qw, qx, qy, qz with a norm between 1e-6 and 1e6");
  return normalized_once(orientation);
}

ToolPart part_of(TomlTable table) {
  ToolPart part;
  part.name = table.at("name").text();
  const auto a = table.at("semi_axes").numbers<3>(kMinToolAxis, kMaxToolAxis);
  part.semi_axes = {a[0], a[1], a[2]};
  if (const auto position = table.find("position")) {
    const auto p = position->numbers<3>(-kMaxToolAxis, kMaxToolAxis);
    part.pose.position = {p[0], p[1], p[2]};
  }
  if (const auto orientation = table.find("orientation"))
    part.pose.orientation = orientation_of(*orientation);
  table.refuse_others();
  return part;
}

/// TOML string: quoted, with special characters escaped.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte >= 0x20 && byte != 0x7f && c != '"' && c != '\\' && c != '\'';
    result += plain ? std::string(1, c) : fmt::format("\\u{:04x}", byte);
  }
  return result + '"';
}

Tool tool_of(const TomlFile& file) {
  TomlTable root = file.root();
  const TomlValue ellipsoids = root.at("ellipsoid");
  root.refuse_others();
  std::vector<ToolPart> parts;
  for (const TomlTable& table : ellipsoids.tables()) parts.push_back(part_of(table));
  if (parts.empty() || parts.size() > kMaxToolParts)
    throw Error("{}: has {} ellipsoids; a tool has 1 to {}", file.path(), parts.size(), kMaxToolParts);
  return Tool(std::move(parts));
}

}  // namespace

Tool read_tool(const std::string& path) { return tool_of(TomlFile(path)); }

Tool parse_tool(const std::string& name, std::string_view text) { return tool_of(TomlFile(name, text)); }

std::string tool_text(const Tool& tool) {
  std::string text;
  for (const ToolPart& part : tool.parts()) {
    const Eigen::Vector3d &a = part.semi_axes, &p = part.pose.position;
    const Eigen::Quaterniond& q = part.pose.orientation;
    text += fmt::format("[[ellipsoid]]\nname = {}\nsemi_axes = [{}, {}, {}]\n", quoted(part.name), a.x(),
                        a.y(), a.z());
    text += fmt::format("position = [{}, {}, {}]\norientation = [{}, {}, {}, {}]\n", p.x(), p.y(), p.z(),
                        q.w(), q.x(), q.y(), q.z());
  }
  return text;
}

}  // namespace palpate

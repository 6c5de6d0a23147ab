#include <palpate/kinematics/chain_file.h>

#include <cmath>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/base/toml_file.h>
#include <palpate/kinematics/chain_assembly.h>
#include <palpate/kinematics/kdl_check.h>
#include <palpate/kinematics/urdf_listing.h>

namespace palpate {
namespace {

constexpr std::uint64_t kMaxBytes = 1 << 20;

Eigen::Vector3d vector_of(const TomlValue& value) {
  const auto v = value.numbers<3>();
  return {v[0], v[1], v[2]};
}

Eigen::Vector3d direction_of(const TomlValue& value) {
  const Eigen::Vector3d v = vector_of(value);
  if (!(v.norm() > 1e-6 && v.norm() < 1e6))
    throw value.must_be("a direction with a norm between 1e-6 and 1e6");
  return v.normalized();
}

Eigen::Quaterniond orientation_of(const TomlValue& value) {
  const auto q = value.numbers<4>();
  const Eigen::Quaterniond orientation(q[0], q[1], q[2], q[3]);
  if (!(orientation.norm() > 1e-6 && orientation.norm() < 1e6))
    throw value.must_be("a quaternion qw, qx, qy, qz with a norm between 1e-6 and 1e6");
  return orientation.normalized();
}

ListedLink link_of(TomlTable table) {
  ListedLink link;
  link.name = table.at("name").text();
  if (const auto mass = table.find("mass")) link.inertia.mass = mass->number();
  if (const auto center = table.find("center")) link.inertia.center = vector_of(*center);
  if (const auto inertia = table.find("inertia")) {
    const auto i = inertia->numbers<6>();
    link.inertia.inertia << i[0], i[3], i[4], i[3], i[1], i[5], i[4], i[5], i[2];
  }
  table.refuse_others();
  return link;
}

void read_limits(TomlTable& table, ChainJoint& joint) {
  JointLimits& limits = joint.limits;
  limits.lower = table.at("lower").number();
  limits.upper = table.at("upper").number();
  limits.velocity = table.at("velocity").number();
  limits.acceleration = table.at("acceleration").number();
  if (const auto effort = table.find("effort")) limits.effort = effort->number();
  joint.rest = 0.5 * (limits.lower + limits.upper);
  if (const auto rest = table.find("rest")) joint.rest = rest->number();
}

ListedJoint joint_of(TomlTable table) {
  ListedJoint listed;
  ChainJoint& joint = listed.joint;
  joint.name = table.at("name").text();
  listed.parent = table.at("parent").text();
  listed.child = table.at("child").text();
  if (const auto position = table.find("position")) joint.origin.position = vector_of(*position);
  if (const auto orientation = table.find("orientation"))
    joint.origin.orientation = orientation_of(*orientation);
  const TomlValue type = table.at("type");
  if (type.text() == "fixed") {
    listed.fixed = true;
  } else {
    if (type.text() != "prismatic" && type.text() != "revolute")
      throw type.must_be("'prismatic', 'revolute' or 'fixed'");
    joint.type = type.text() == "prismatic" ? JointType::kPrismatic : JointType::kRevolute;
    joint.axis = direction_of(table.at("axis"));
    read_limits(table, joint);
  }
  table.refuse_others();
  return listed;
}

ChainListing toml_listing(const std::string& name, std::string_view text) {
  const TomlFile file(name, text);
  TomlTable root = file.root();
  ChainListing listing;
  listing.where = name;
  listing.name = root.at("name").text();
  if (const auto base = root.find("base")) listing.base = base->text();
  if (const auto tip = root.find("tip")) listing.tip = tip->text();
  for (const TomlTable& table : root.at("link").tables()) listing.links.push_back(link_of(table));
  for (const TomlTable& table : root.at("joint").tables()) listing.joints.push_back(joint_of(table));
  root.refuse_others();
  return listing;
}

bool is_xml(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  return first != std::string_view::npos && text[first] == '<';
}

}  // namespace

SerialChain parse_chain(const std::string& name, std::string_view text) {
  SerialChain chain = assemble_chain(is_xml(text) ? urdf_listing(name, text) : toml_listing(name, text));
  compare_with_kdl(chain, name);
  return chain;
}

SerialChain read_chain(const std::string& path) { return parse_chain(path, read_text_file(path, kMaxBytes)); }

SerialChain giant_chain() { return parse_chain("giant.toml", giant_chain_text()); }

}  // namespace palpate

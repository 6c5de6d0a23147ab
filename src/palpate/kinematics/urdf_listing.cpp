#include <palpate/kinematics/urdf_listing.h>

#include <algorithm>
#include <cctype>
#include <mutex>
#include <numbers>
#include <utility>

#include <console_bridge/console.h>
#include <urdf_model/link.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <palpate/base/error.h>
#include <palpate/kinematics/chain_file.h>

namespace palpate {
namespace {

/// Largest nesting depth of elements: the parser recurses once per level.
constexpr int kDeepest = 64;
/// Assumed limit of a continuous joint, in each direction. Unit: [rad].
constexpr double kContinuous = 4.0 * std::numbers::pi;

/// Records the first error that the parser logs, and keeps its output off the terminal.
class FirstError final : public console_bridge::OutputHandler {
 public:
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first_.empty()) first_ = text;
  }
  const std::string& first() const { return first_; }

 private:
  std::string first_;
};

/// True if the '<' before `next` begins an element for TinyXML, which urdfdom uses.
bool begins_element(char next) {
  return std::isalpha(static_cast<unsigned char>(next)) != 0 || next == '_' ||
         static_cast<unsigned char>(next) >= 0x7f;
}

/// Returns the position of the '>' that ends the start tag at `k`: those within quotes do not. npos if there
/// is none.
std::size_t end_of_start_tag(std::string_view text, std::size_t k) {
  char quote = '\0';
  for (; k < text.size(); ++k) {
    if (quote != '\0') {
      if (text[k] == quote) quote = '\0';
    } else if (text[k] == '"' || text[k] == '\'') {
      quote = text[k];
    } else if (text[k] == '>') {
      return k;
    }
  }
  return std::string_view::npos;
}

/// Returns the position of the last character of what begins with the '<' at `k`; npos if it has no end.
std::size_t end_of_markup(std::string_view text, std::size_t k) {
  using Ends = std::pair<std::string_view, std::string_view>;
  for (const auto& [begin, end] : {Ends{"<!--", "-->"}, Ends{"<![CDATA[", "]]>"}}) {
    if (!text.substr(k).starts_with(begin)) continue;
    const std::size_t at = text.find(end, k + begin.size());
    return at == std::string_view::npos ? at : at + end.size() - 1;
  }
  return k + 1 < text.size() && begins_element(text[k + 1]) ? end_of_start_tag(text, k) : text.find('>', k);
}

/// Nesting depth of the elements, found without recursion. For text that is not well-formed, it is that of
/// the part that a parser reads before it refuses it.
int depth(std::string_view text) {
  int now = 0, deepest = 0;
  for (std::size_t k = text.find('<'); k != std::string_view::npos; k = text.find('<', k)) {
    const std::size_t end = end_of_markup(text, k);
    if (end == std::string_view::npos) break;
    if (text[k + 1] == '/') --now;
    if (begins_element(text[k + 1])) {
      deepest = std::max(deepest, now + 1);
      if (text[end - 1] != '/') ++now;
    }
    k = end;
  }
  return deepest;
}

urdf::ModelInterfaceSharedPtr parsed(const std::string& name, std::string_view text) {
  if (depth(text) > kDeepest) throw Error("{}: its elements are nested more than {} deep", name, kDeepest);
  static std::mutex one_at_a_time;  // the output handler is global to the process
  const std::lock_guard lock(one_at_a_time);
  FirstError error;
  console_bridge::useOutputHandler(&error);
  urdf::ModelInterfaceSharedPtr model;
  std::string thrown;
  try {
    model = urdf::parseURDF(std::string(text));
  } catch (const std::exception& e) {
    thrown = e.what();
  }
  console_bridge::restorePreviousOutputHandler();
  const std::string& why = error.first().empty() ? thrown : error.first();
  if (model == nullptr)
    throw Error("{}: is not valid URDF: {}", name, why.empty() ? "it cannot be parsed" : why);
  // A loop of links would never be freed; callers use the model's own lists.
  for (const auto& [link, given] : model->links_) given->child_links.clear();
  return model;
}

Pose pose_of(const urdf::Pose& pose) {
  Pose result;
  result.position = {pose.position.x, pose.position.y, pose.position.z};
  double x = 0, y = 0, z = 0, w = 1;
  pose.rotation.getQuaternion(x, y, z, w);
  result.orientation = Eigen::Quaterniond(w, x, y, z).normalized();
  return result;
}

LinkInertia inertia_of(const urdf::Link& link) {
  LinkInertia inertia;
  if (link.inertial == nullptr) return inertia;
  const urdf::Inertial& given = *link.inertial;
  const Pose at = pose_of(given.origin);
  Eigen::Matrix3d I;
  I << given.ixx, given.ixy, given.ixz, given.ixy, given.iyy, given.iyz, given.ixz, given.iyz, given.izz;
  const Eigen::Matrix3d R = at.orientation.toRotationMatrix();
  return {given.mass, at.position, R * I * R.transpose()};
}

void set_limits(ChainJoint& joint, const urdf::Joint& given, const std::string& where) {
  if (given.limits == nullptr) throw Error("{}: joint '{}' has no <limit>", where, given.name);
  const bool turns_on = given.type == urdf::Joint::CONTINUOUS;
  JointLimits& limits = joint.limits;
  limits.lower = turns_on ? -kContinuous : given.limits->lower;
  limits.upper = turns_on ? kContinuous : given.limits->upper;
  if (given.safety != nullptr && !turns_on) {  // the manufacturer's soft limits
    limits.lower = std::max(limits.lower, given.safety->soft_lower_limit);
    limits.upper = std::min(limits.upper, given.safety->soft_upper_limit);
  }
  limits.velocity = given.limits->velocity;
  limits.acceleration = limits.velocity / kUrdfRampTime;
  limits.effort = given.limits->effort;
  joint.rest = 0.5 * (limits.lower + limits.upper);
}

ListedJoint listed(const urdf::Joint& given, const std::string& where) {
  ListedJoint result;
  result.parent = given.parent_link_name;
  result.child = given.child_link_name;
  ChainJoint& joint = result.joint;
  joint.name = given.name;
  joint.origin = pose_of(given.parent_to_joint_origin_transform);
  result.fixed = given.type == urdf::Joint::FIXED;
  if (result.fixed) return result;
  if (given.mimic != nullptr)
    throw Error("{}: joint '{}': mimic joints are not supported", where, given.name);
  switch (given.type) {
    case urdf::Joint::REVOLUTE:
    case urdf::Joint::CONTINUOUS: joint.type = JointType::kRevolute; break;
    case urdf::Joint::PRISMATIC: joint.type = JointType::kPrismatic; break;
    default: throw Error("{}: joint '{}' is neither prismatic, revolute nor fixed", where, given.name);
  }
  const Eigen::Vector3d axis(given.axis.x, given.axis.y, given.axis.z);
  if (!(axis.norm() > 1e-6)) throw Error("{}: joint '{}' has no axis", where, given.name);
  joint.axis = axis.normalized();
  set_limits(joint, given, where);
  return result;
}

}  // namespace

ChainListing urdf_listing(const std::string& name, std::string_view text) {
  const urdf::ModelInterfaceSharedPtr model = parsed(name, text);
  ChainListing listing;
  listing.name = model->getName();
  listing.where = name;
  for (const auto& [link, given] : model->links_) listing.links.push_back({link, inertia_of(*given)});
  for (const auto& [joint, given] : model->joints_) listing.joints.push_back(listed(*given, name));
  return listing;
}

}  // namespace palpate

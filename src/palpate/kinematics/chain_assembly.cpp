#include <palpate/kinematics/chain_assembly.h>

#include <algorithm>
#include <map>

#include <palpate/base/error.h>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Inertia of a point mass at the vector `away` from the reference point. Unit: [kg m^2].
Matrix3d point_inertia(double mass, const Vector3d& away) {
  return mass * (away.squaredNorm() * Matrix3d::Identity() - away * away.transpose());
}

/// Inertia of two bodies that are fixed to each other, in the frame of `a`. \param X pose of the frame of `b`
/// in that of `a`
LinkInertia joined(const LinkInertia& a, const Pose& X, const LinkInertia& b) {
  LinkInertia both;
  both.mass = a.mass + b.mass;
  const Matrix3d R = X.orientation.toRotationMatrix();
  const Vector3d center_b = X.position + R * b.center;
  if (both.mass > 0.0) both.center = (a.mass * a.center + b.mass * center_b) / both.mass;
  both.inertia = a.inertia + point_inertia(a.mass, a.center - both.center) + R * b.inertia * R.transpose() +
                 point_inertia(b.mass, center_b - both.center);
  return both;
}

class Assembly {
 public:
  explicit Assembly(const ChainListing& listing) : listing_(listing) {
    for (const ListedLink& link : listing.links)
      if (!links_.emplace(link.name, &link).second)
        throw Error("{}: two links are named '{}'", listing.where, link.name);
    for (const ListedJoint& joint : listing.joints) add(joint);
  }

  SerialChain chain() const {
    const std::string base = listing_.base.empty() ? root() : listing_.base;
    require_link(base, "the base");
    const std::vector<const ListedJoint*> way =
        way_to(listing_.tip.empty() ? leaf(base) : listing_.tip, base);
    refuse_branches(way, base);
    SerialChain chain;
    chain.name = listing_.name;
    Pose before;  // of the next joint's parent, in the frame of the last moving link
    for (const ListedJoint* listed : way) append(chain, before, *listed);
    chain.tip = before;
    check_chain(chain, listing_.where);
    return chain;
  }

 private:
  void add(const ListedJoint& joint) {
    const std::string& name = joint.joint.name;
    require_link(joint.parent, "the parent of joint '" + name + "'");
    require_link(joint.child, "the child of joint '" + name + "'");
    const auto [other, is_new] = above_.emplace(joint.child, &joint);
    if (!is_new)
      throw Error("{}: link '{}' has two parent joints, '{}' and '{}'; a serial chain has no loops",
                  listing_.where, joint.child, other->second->joint.name, name);
  }

  void require_link(const std::string& name, const std::string& what) const {
    if (!links_.contains(name)) throw Error("{}: {}: link '{}' does not exist", listing_.where, what, name);
  }

  std::string root() const {
    std::string found;
    for (const ListedLink& link : listing_.links) {
      if (above_.contains(link.name)) continue;
      if (!found.empty())
        throw Error("{}: links '{}' and '{}' have no parent joint; set `base` to one and connect the other",
                    listing_.where, found, link.name);
      found = link.name;
    }
    if (found.empty())
      throw Error("{}: every link has a parent joint; a serial chain has no loops", listing_.where);
    return found;
  }

  std::string leaf(const std::string& base) const {
    std::string at = base;
    for (std::size_t k = 0; k <= listing_.joints.size(); ++k) {
      const ListedJoint* next = nullptr;
      for (const ListedJoint& joint : listing_.joints) {
        if (joint.parent != at) continue;
        if (next != nullptr) refuse_branch(at, *next, joint);
        next = &joint;
      }
      if (next == nullptr) return at;
      at = next->child;
    }
    throw Error("{}: the joints form a loop through link '{}'", listing_.where, at);
  }

  [[noreturn]] void refuse_branch(const std::string& link, const ListedJoint& a, const ListedJoint& b) const {
    throw Error("{}: link '{}' is the parent of two joints, '{}' and '{}'; a serial chain has no branches",
                listing_.where, link, a.joint.name, b.joint.name);
  }

  std::vector<const ListedJoint*> way_to(const std::string& tip, const std::string& base) const {
    require_link(tip, "the tip");
    std::vector<const ListedJoint*> way;
    for (std::string at = tip; at != base;) {
      const auto above = above_.find(at);
      if (above == above_.end())
        throw Error("{}: link '{}' is not connected to the base '{}'", listing_.where, tip, base);
      way.push_back(above->second);
      at = above->second->parent;
      if (way.size() > listing_.joints.size())
        throw Error("{}: the joints form a loop through link '{}'", listing_.where, at);
    }
    std::reverse(way.begin(), way.end());
    return way;
  }

  /// Returns true if the joints above `joint` form a loop.
  bool goes_round(const ListedJoint& joint) const {
    std::string at = joint.parent;
    for (std::size_t k = 0; k <= listing_.joints.size(); ++k) {
      const auto above = above_.find(at);
      if (above == above_.end()) return false;
      at = above->second->parent;
    }
    return true;
  }

  void refuse_branches(const std::vector<const ListedJoint*>& way, const std::string& base) const {
    for (const ListedJoint& joint : listing_.joints) {
      if (std::find(way.begin(), way.end(), &joint) != way.end()) continue;
      for (const ListedJoint* other : way)
        if (other->parent == joint.parent) refuse_branch(joint.parent, *other, joint);
      if (joint.child == base || goes_round(joint))
        throw Error("{}: joint '{}' closes a loop through link '{}'; a serial chain has no loops",
                    listing_.where, joint.joint.name, joint.child);
      throw Error("{}: joint '{}' is not between base '{}' and the tip", listing_.where, joint.joint.name,
                  base);
    }
  }

  /// Appends a joint, or merges a fixed one with the last link. \param before pose of this joint's parent, in
  /// the frame of the last moving link; updated to that of its child
  void append(SerialChain& chain, Pose& before, const ListedJoint& listed) const {
    const Pose here = before * listed.joint.origin;
    const LinkInertia& inertia = links_.at(listed.child)->inertia;
    if (listed.fixed) {
      before = here;
      if (chain.joints.empty()) return;  // links fixed to the base need no inertia
      LinkInertia& carries = chain.joints.back().link;
      carries = joined(carries, here, inertia);
      return;
    }
    chain.joints.push_back(listed.joint);
    chain.joints.back().origin = here;
    chain.joints.back().link = inertia;
    before = {};
  }

  const ChainListing& listing_;
  std::map<std::string, const ListedLink*> links_;
  std::map<std::string, const ListedJoint*> above_;  ///< joint of which each link is the child
};

}  // namespace

SerialChain assemble_chain(const ChainListing& listing) { return Assembly(listing).chain(); }

}  // namespace palpate

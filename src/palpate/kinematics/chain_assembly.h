/// \file
/// Assembly of a serial chain from a file's list of links and joints.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <palpate/kinematics/serial_chain.h>

namespace palpate {

struct ListedLink {
  std::string name;
  LinkInertia inertia;
};

/// A joint between two named links; fixed joints have no type.
struct ListedJoint {
  ChainJoint joint;
  bool fixed = false;
  std::string parent, child;
};

/// Links and joints of a file, in its order.
struct ChainListing {
  std::string name, where;  ///< of the chain; prefix of messages
  std::string base, tip;    ///< link names; empty: the only candidate
  std::vector<ListedLink> links;
  std::vector<ListedJoint> joints;
};

/// The chain from base to tip. \throws Error for links that are missing, listed twice or reached twice, for
/// loops and branches, and as check_chain().
SerialChain assemble_chain(const ChainListing& listing);

}  // namespace palpate

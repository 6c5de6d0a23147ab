/// \file
/// A serial chain from the links and joints that a file lists.
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

/// A joint between two links that are called by name; fixed where it has no type.
struct ListedJoint {
  ChainJoint joint;
  bool fixed = false;
  std::string parent, child;
};

/// What a file says, in its own order.
struct ChainListing {
  std::string name, where;  ///< of the chain, and what messages begin with
  std::string base, tip;    ///< links; empty: the only one that may be
  std::vector<ListedLink> links;
  std::vector<ListedJoint> joints;
};

/// The chain from base to tip. \throws Error for links that are missing, listed twice or reached twice, for
/// loops and branches, and as check_chain().
SerialChain assemble_chain(const ChainListing& listing);

}  // namespace palpate

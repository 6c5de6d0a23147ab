/// \file
/// What a node prints for --help.
#pragma once

namespace palpate::node {

/// A node, as its help names it.
struct NodeCommand {
  const char* summary;    ///< one line
  const char* usage;      ///< its name and arguments
  const char* separator;  ///< between a hand's name and a parameter of it
};

/// Prints the arguments of a node if --help or -h is one of them. \returns true if it did
bool print_help(const NodeCommand& command, int argc, const char* const* argv);

}  // namespace palpate::node

/// \file
/// A parameter of a node, as its network has it. Without other headers; see node_sink.h.
#pragma once

#include <string>

namespace palpate::node {

/// A private parameter as text; numbers of an array separated by commas.
struct NodeParameter {
  std::string name, value;
};

}  // namespace palpate::node

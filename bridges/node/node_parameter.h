/// \file
/// A parameter of a node. Includes no headers of ROS or Palpate; see node_sink.h.
#pragma once

#include <string>

namespace palpate::node {

/// A private parameter as text; elements of an array are separated by commas.
struct NodeParameter {
  std::string name, value;
};

}  // namespace palpate::node

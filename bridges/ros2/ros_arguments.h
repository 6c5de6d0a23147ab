/// \file
/// Command line of a ROS 2 node.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <node_parameter.h>

namespace palpate::ros2 {

/// Node name, namespace and remappings. Immutable.
struct Names {
  std::string node = "palpate";
  std::string space = "/";                    ///< namespace of the node, such as "/left"
  std::map<std::string, std::string> remaps;  ///< absolute names: from, to

  /// Absolute, remapped name of "/omni/measured_cp", or of "palpate/tool", which is in the node's namespace.
  std::string resolve(const std::string& name) const;
};

struct NodeArguments {
  Names names;
  std::string enclave = "/";  ///< see enclave_of_environment()
  std::vector<node::NodeParameter> parameters;
};

/// Reads `-r FROM:=TO` (also `__node:=NAME` and `__ns:=NAMESPACE`), `-p NAME:=VALUE` and `--enclave NAME`
/// between
/// `--ros-args` and `--`. Arrays are written `[1.0, 2.0]`. \throws Error for any other argument.
NodeArguments read_arguments(int argc, const char* const* argv);

}  // namespace palpate::ros2

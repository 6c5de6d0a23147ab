/// \file
/// Arguments of a node, as ROS 2 has them.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <node_parameter.h>

namespace palpate::ros2 {

/// Names as a node is started with them. Immutable.
struct Names {
  std::string node = "palpate";
  std::string space = "/";                    ///< of the node; "/left"
  std::map<std::string, std::string> remaps;  ///< from and to, both from their slash on

  /// Of "/omni/measured_cp", or of "palpate/tool" in the node's namespace: from its slash on, remapped.
  std::string resolve(const std::string& name) const;
};

struct NodeArguments {
  Names names;
  std::string enclave = "/";  ///< of DDS Security
  std::vector<node::NodeParameter> parameters;
};

/// Reads `--ros-args`, then `-r FROM:=TO` (`__node:=NAME`, `__ns:=NAMESPACE`, too), `-p NAME:=VALUE` and
/// `--enclave NAME`, up to `--`. An array's value is written
/// `[1.0, 2.0]`. \throws Error for any other argument.
NodeArguments read_arguments(int argc, const char* const* argv);

}  // namespace palpate::ros2

/// \file
/// The tools of examples/tools.
#pragma once

#include <string>

namespace palpate::test {

/// The path of examples/tools/NAME.toml.
inline std::string example_tool(const std::string& name) {
  return PALPATE_EXAMPLES "/tools/" + name + ".toml";
}

}  // namespace palpate::test

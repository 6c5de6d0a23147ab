// Tool files: read_tool() either throws Error or returns a tool within its bounds, with consistent sizes.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <palpate/base/error.h>
#include <palpate/haptics/tool_file.h>

#include "input_file.h"

namespace {

using palpate::fuzz::require;

void check(const palpate::ToolPart& part) {
  const auto& a = part.semi_axes;
  require(a.minCoeff() >= palpate::kMinToolAxis && a.maxCoeff() <= palpate::kMaxToolAxis);
  require(part.pose.position.cwiseAbs().maxCoeff() <= palpate::kMaxToolAxis);
  require(std::abs(part.pose.orientation.norm() - 1.0) < 1e-12);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static palpate::fuzz::InputFile file;
  try {
    const palpate::Tool tool = palpate::read_tool(file.hold(data, size, "tool.toml"));
    require(!tool.parts().empty() && tool.parts().size() <= palpate::kMaxToolParts);
    for (const palpate::ToolPart& part : tool.parts()) check(part);
    const double least = tool.thinnest(), most = tool.radius() * (1.0 + 1e-12);
    require(0.0 < least && least <= tool.longest() && tool.longest() <= most);
    require(0.0 < tool.gyration() && tool.gyration() <= most);
    require(-most <= tool.support(Eigen::Vector3d::UnitZ()) &&
            tool.support(Eigen::Vector3d::UnitZ()) <= most);
  } catch (const palpate::Error&) {
  }
  return 0;
}

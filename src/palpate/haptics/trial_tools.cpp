#include <palpate/haptics/trial_tools.h>

#include <array>
#include <utility>
#include <vector>

namespace palpate {
namespace {

constexpr std::array<std::string_view, 8> kNames{"ball20", "ball10", "ball5", "ball2",
                                                 "rod",    "needle", "disc",  "plate"};

}  // namespace

std::span<const std::string_view> trial_tools() { return kNames; }

std::optional<Tool> trial_tool(std::string_view name) {
  if (name == "ball20") return Tool({0.02, 0.02, 0.02});
  if (name == "ball10") return Tool({0.01, 0.01, 0.01});
  if (name == "ball5") return Tool({0.005, 0.005, 0.005});
  if (name == "ball2") return Tool({0.002, 0.002, 0.002});
  if (name == "rod") return Tool({0.1, 0.003, 0.003});
  if (name == "needle") return Tool({0.005, 0.005, 0.1});
  if (name == "disc") return Tool({0.03, 0.03, 0.005});
  if (name == "plate") return Tool({0.1, 0.1, 0.01});
  return {};
}

Tool turned(const Tool& tool, const Eigen::Quaterniond& turn) {
  std::vector<ToolPart> parts(tool.parts().begin(), tool.parts().end());
  for (ToolPart& part : parts) part.pose = Pose{Eigen::Vector3d::Zero(), turn} * part.pose;
  return Tool(std::move(parts));
}

}  // namespace palpate

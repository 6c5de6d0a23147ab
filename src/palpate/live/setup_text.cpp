#include <palpate/live/setup_text.h>

#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <palpate/live/setup_json.h>

namespace palpate {
namespace {

/// A command-line option to paste (empty if nothing needs to be set), and the reason.
struct Line {
  std::string option, reason;
};

std::vector<Line> lines_of(const SceneSetup& setup) {
  const bool turned = setup.frame.value != UpAxis::kAsIs;
  const auto& longest = setup.max_scale.value;
  const auto& crop = setup.crop_box.value;
  return {
      {turned ? fmt::format("--frame {}", to_string(setup.frame.value)) : "", setup.frame.reason},
      {fmt::format("--scale {}", setup.scale.value), setup.scale.reason},
      {fmt::format("--opacity-min {}", setup.opacity_min.value), setup.opacity_min.reason},
      {longest ? fmt::format("--max-scale {:.3g}", *longest) : "", setup.max_scale.reason},
      {crop ? fmt::format("--crop-box {:.3g}", fmt::join(corners(*crop), ",")) : "", setup.crop_box.reason}};
}

}  // namespace

std::string setup_text(const SceneSetup& setup) {
  std::vector<std::string> options;
  for (const Line& line : lines_of(setup))
    if (!line.option.empty()) options.push_back(line.option);
  std::string text = fmt::format("proposed          {}\n", fmt::join(options, " "));
  for (const auto& [option, reason] : lines_of(setup)) {
    const std::string name = option.substr(0, option.find(' '));
    text += fmt::format("  {:<15} {}\n", name.empty() ? "-" : name, reason);
  }
  return text;
}

}  // namespace palpate

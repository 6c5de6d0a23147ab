#include "output.h"

#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/base/version.h>

namespace palpate::cli {

std::string program_version() { return fmt::format("palpate {}", version()); }

std::string notice(std::string_view message) { return fmt::format("palpate: {}\n", message_line(message)); }

void notify(std::string_view message) { fmt::print(stderr, "{}", notice(message)); }

void print_json(const Json& json) { fmt::print("{}\n", json_text(json, 2)); }

std::string tool_in_words(const Tool& tool) {
  if (tool.parts().size() > 1) return fmt::format("{} ellipsoids", tool.parts().size());
  const Eigen::Vector3d mm = 1e3 * tool.parts()[0].semi_axes;
  return fmt::format("{:g}/{:g}/{:g} mm", mm.x(), mm.y(), mm.z());
}

void check_output(const std::string& out, const std::vector<std::string>& inputs, std::string_view option) {
  for (const std::string& input : inputs) {
    if (!out.empty() && !input.empty() && same_file(out, input)) {
      throw Error("{}: {} is also an input; give it another name", out, option);
    }
  }
}

void check_ending(const std::string& out, std::string_view ending, std::string_view option) {
  const std::string found = std::filesystem::path(out).extension().string();
  if (!found.empty() && found != ending)
    throw Error("{}: {} writes {}; end the name in {}", out, option, ending.substr(1), ending);
}

void check_results(const ResultNames& names, std::vector<std::string> inputs) {
  check_output(names.csv, inputs, "--csv");
  inputs.push_back(names.csv);
  check_output(names.html, inputs, "--html");
  check_ending(names.html, ".html", "--html");
  check_figure_folder(names.svg);
}

void print_written(const std::vector<std::string>& files) {
  for (const std::string& file : files) fmt::print("wrote {}\n", printable(file));
}

void add_reach(const PaperPipeline& paper, const Tool& tool, Json& json) {
  json["search_radius"] = paper.search_radius();
  json["can_miss"] = paper.can_miss(tool.longest());
}

void print_reach(const PaperPipeline& paper, const Tool& tool) {
  fmt::print("{1} Gaussians reach beyond the search radius of {0:.4g} m and may be missed\n",
             paper.search_radius(), paper.can_miss(tool.longest()));
}

}  // namespace palpate::cli

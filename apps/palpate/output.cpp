#include "output.h"

#include <cstdio>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>

namespace palpate::cli {

void notify(std::string_view message) { fmt::print(stderr, "palpate: {}\n", message_line(message)); }

Json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

void check_output(const std::string& out, std::initializer_list<std::string> inputs,
                  std::string_view option) {
  for (const std::string& input : inputs) {
    if (!out.empty() && !input.empty() && same_file(out, input)) {
      throw Error("{}: {} is also an input; give it another name", out, option);
    }
  }
}

void add_reach(const PaperPipeline& paper, const Tool& tool, Json& json) {
  json["search_radius"] = paper.search_radius();
  json["can_miss"] = paper.can_miss(tool.semi_axes.maxCoeff());
}

void print_reach(const PaperPipeline& paper, const Tool& tool) {
  fmt::print("the search radius of {:.4g} m can miss {} Gaussians, whatever the pose\n",
             paper.search_radius(), paper.can_miss(tool.semi_axes.maxCoeff()));
}

}  // namespace palpate::cli

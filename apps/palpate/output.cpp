#include "output.h"

#include <fmt/format.h>

namespace palpate::cli {

Json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

void add_reach(const PaperPipeline& paper, const Tool& tool, Json& json) {
  json["search_radius"] = paper.search_radius();
  json["can_miss"] = paper.can_miss(tool.semi_axes.maxCoeff());
}

void print_reach(const PaperPipeline& paper, const Tool& tool) {
  fmt::print("the search radius of {:.4g} m can miss {} Gaussians, whatever the pose\n",
             paper.search_radius(), paper.can_miss(tool.semi_axes.maxCoeff()));
}

}  // namespace palpate::cli

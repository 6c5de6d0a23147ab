// The paper's own pipeline: kd-tree over centres (nanoflann), bounding spheres, golden section.
#include <string>
#include <utility>

#include <palpate/collision/paper_pipeline.h>

#include "contact_hits.h"
#include "pipeline.h"

namespace palpate::bench {
namespace {

class Paper final : public Pipeline {
 public:
  Paper(std::string name, const EllipsoidScene& scene, double search_radius)
      : name_(std::move(name)), pipeline_(scene, search_radius) {}

  std::string name() const override { return name_; }
  void query(const Ellipsoid& tool) override { pipeline_.query(tool, contacts_); }
  void hits(std::vector<Hit>& out) const override { assign_hits(contacts_, out); }

 private:
  std::string name_;
  PaperPipeline pipeline_;
  ContactSet contacts_;
};

}  // namespace

Pipelines build_paper(const PipelineInput& input) {
  return only<Paper>("paper (nanoflann)", input.ellipsoids, input.search_radius);
}

Pipelines build_complete_paper(const PipelineInput& input) {
  return only<Paper>("paper, complete radius", input.ellipsoids, input.complete_radius);
}

}  // namespace palpate::bench

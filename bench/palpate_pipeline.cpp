// This library: fresh queries on every instruction set, and the tracker on the best one.
#include <array>
#include <string_view>
#include <utility>

#include <fmt/core.h>

#include <palpate/collision/contact_tracker.h>
#include <palpate/collision/scene_index.h>
#include <palpate/collision/simd_target.h>

#include "contact_hits.h"
#include "pipeline.h"

namespace palpate::bench {
namespace {

using Index = std::shared_ptr<const SceneIndex>;

constexpr std::array kPrecisions{Precision::kDouble, Precision::kSingle};

std::string_view suffix(Precision precision) { return precision == Precision::kSingle ? " single" : ""; }

class FreshQuery final : public Pipeline {
 public:
  FreshQuery(Index index, std::string target, Precision precision)
      : index_(std::move(index)), target_(std::move(target)), precision_(precision) {}

  std::string name() const override { return fmt::format("palpate {}{}", target_, suffix(precision_)); }
  void prepare() override { use_simd_target(target_); }
  void query(const Ellipsoid& tool) override { index_->query(tool, precision_, contacts_); }
  void hits(std::vector<Hit>& out) const override { assign_hits(contacts_, out); }

 private:
  Index index_;
  std::string target_;
  Precision precision_;
  ContactSet contacts_;
};

class TrackedQuery final : public Pipeline {
 public:
  TrackedQuery(Index index, std::string target, Precision precision)
      : index_(std::move(index)),
        target_(std::move(target)),
        precision_(precision),
        tracker_(*index_, precision) {}

  std::string name() const override {
    return fmt::format("palpate tracker {}{}", target_, suffix(precision_));
  }
  void prepare() override { use_simd_target(target_); }
  void query(const Ellipsoid& tool) override { tracker_.query(tool, contacts_); }
  void hits(std::vector<Hit>& out) const override { assign_hits(contacts_, out); }

 private:
  Index index_;
  std::string target_;
  Precision precision_;
  ContactTracker tracker_;
  ContactSet contacts_;
};

}  // namespace

Pipelines pipelines_of(const Index& index, bool every_target) {
  std::vector<std::string> targets = simd_targets();
  if (!every_target) targets.resize(1);
  Pipelines pipelines;
  for (const std::string& target : targets) {
    for (const Precision p : kPrecisions) pipelines.push_back(std::make_unique<FreshQuery>(index, target, p));
  }
  for (const Precision p : kPrecisions) {
    pipelines.push_back(std::make_unique<TrackedQuery>(index, targets.front(), p));
  }
  return pipelines;
}

Pipelines build_palpate(const PipelineInput& input) {
  return pipelines_of(std::make_shared<const SceneIndex>(input.scene, input.filter, Similarity{}),
                      input.every_target);
}

}  // namespace palpate::bench

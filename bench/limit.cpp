// Lower bound of the time of a contact query: the operations that its mathematics needs, divided by the
// peak rate of the processor; compared with the measured time.
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "program.h"
#include "report.h"
#include "vector_rate.h"

namespace palpate::bench {
namespace {

/// Number of operations on single-precision lanes per item of a stage; a multiply-add, a comparison and an
/// estimate of a reciprocal count as one each. Counted from the formulas of the kernel, without data
/// movement: loads, stores, packing, loops. Must be counted again when the formulas change.
namespace cost {

/// Slot of a visited node: six comparisons and five conjunctions of boxes; for the separating plane, m and h
/// 12, M m 9, m^T M m 3, the extent 6, the size 6, the gap and its test 7 (walk_lanes-inl.h, expand).
constexpr double kSlot = 6 + 5 + 12 + 9 + 3 + 6 + 6 + 7;

/// Gaussian of a block: centre relative to the tool 6, W times it 9, its square 3, longest axis 2, reach 1,
/// its square 2, the comparison 1 (walk_lanes-inl.h, cull).
constexpr double kCandidate = 6 + 9 + 3 + 2 + 1 + 2 + 1;

/// Pair that passes the spheres: rotation times lengths 38, d' and L 42, coefficients of K 82
/// (pair_lanes-inl.h), initial guess 18, and the screening step 66 (search_lanes-inl.h).
constexpr double kPair = 38 + 42 + 82 + 18 + 66;

/// Contact: three more steps of the search, a final one with a certificate 90 and its rounding bound 13;
/// normal, point, depth and lambda 150 (contact_lanes-inl.h).
constexpr double kContact = 3 * 66 + 90 + 13 + 150;

}  // namespace cost

/// Number of items per query, means over the poses in contact.
struct Work {
  double slots = 0.0, candidates = 0.0, filtered = 0.0, contacts = 0.0;
};

/// Number of slots of all nodes whose box overlaps that of `tool`; independent of the kernel, in double.
std::size_t count_slots(const IndexView& index, const Ellipsoid& tool) {
  const Eigen::Vector3d low = tool.center - tool.half_extents() - index.origin;
  const Eigen::Vector3d high = tool.center + tool.half_extents() - index.origin;
  std::size_t slots = 0;
  std::vector<std::uint32_t> pending{0};
  while (!pending.empty()) {
    const IndexNode& node = index.nodes[pending.back()];
    pending.pop_back();
    slots += kIndexWidth;
    for (std::size_t i = 0; i < kIndexWidth; ++i) {
      bool meets = (node.child[i] & IndexNode::kLeaf) == 0;
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        meets = meets && node.low[a][i] <= high[axis] && node.high[a][i] >= low[axis];
      }
      if (meets) pending.push_back(node.child[i]);
    }
  }
  return slots;
}

Work mean_work(const SceneIndex& index, const std::vector<Ellipsoid>& touching) {
  Work sum;
  ContactSet set;
  for (const Ellipsoid& tool : touching) {
    index.query(tool, set);
    sum.slots += static_cast<double>(count_slots(index.view(), tool));
    sum.candidates += static_cast<double>(set.candidates);
    sum.filtered += static_cast<double>(set.filtered);
    sum.contacts += static_cast<double>(set.contacts.size());
  }
  const auto n = static_cast<double>(touching.size());
  return {sum.slots / n, sum.candidates / n, sum.filtered / n, sum.contacts / n};
}

std::vector<Ellipsoid> touching_poses(const SceneIndex& index, const BenchScene& scene) {
  std::vector<Ellipsoid> touching;
  ContactSet set;
  for (const Ellipsoid& tool : make_poses(scene, {})) {
    index.query(tool, set);
    if (!set.contacts.empty()) touching.push_back(tool);
  }
  return touching;
}

struct Stage {
  const char* item;
  double items;       ///< per query
  double operations;  ///< per item
};

std::vector<Stage> stages_of(const Work& work) {
  return {{"slots of nodes, against the tool's box", work.slots, cost::kSlot},
          {"Gaussians of blocks, against spheres", work.candidates, cost::kCandidate},
          {"pairs after the bounding-sphere test, screened", work.filtered, cost::kPair},
          {"contacts, searched, minimised and described", work.contacts, cost::kContact}};
}

struct Limit {
  VectorRate rate;
  std::vector<Stage> stages;
  double measured_us;  ///< mean of fresh queries in contact

  double microseconds_of(const Stage& stage) const {
    return 1e6 * stage.items * stage.operations / rate.lanes_per_second;
  }
  double total_us() const {
    double sum = 0.0;
    for (const Stage& stage : stages) sum += microseconds_of(stage);
    return sum;
  }
};

std::string to_markdown(const Limit& limit) {
  std::string text = fmt::format(
      "One core does {:.3g} operations a second on single-precision lanes ({}, independent multiply-adds on "
      "registers).\n\n| of a query | how many | operations each | at that rate |\n|---|---|---|---|\n",
      limit.rate.lanes_per_second, limit.rate.target);
  for (const Stage& stage : limit.stages) {
    text += fmt::format("| {} | {:.1f} | {:.0f} | {} |\n", stage.item, stage.items, stage.operations,
                        microseconds(limit.microseconds_of(stage)));
  }
  const double total = limit.total_us();
  return text + fmt::format(
                    "| **limit** | | | **{}** |\n| **measured**, mean | | | **{}**, {:.1f} times as long |\n",
                    microseconds(total), microseconds(limit.measured_us), limit.measured_us / total);
}

nlohmann::ordered_json to_json(const Limit& limit) {
  nlohmann::ordered_json json{{"machine", palpate::machine()},
                              {"simd", limit.rate.target},
                              {"lanes_per_second", limit.rate.lanes_per_second}};
  for (const Stage& stage : limit.stages)
    json["stages"].push_back(
        {{"item", stage.item}, {"items", stage.items}, {"operations", stage.operations}});
  json["limit_us"] = limit.total_us();
  json["measured_us"] = limit.measured_us;
  return json;
}

Limit find_limit(std::size_t gaussians) {
  const BenchScene scene(gaussians);
  const auto index = std::make_shared<const SceneIndex>(scene.load(), SceneFilter{}, Similarity{});
  const std::vector<Ellipsoid> touching = touching_poses(*index, scene);
  const Pipelines pipelines = pipelines_of(index, false);
  constexpr int kRounds = 5;
  const Latency fresh(measure(pipelines, touching, kRounds).front());
  return {measure_vector_rate(), stages_of(mean_work(*index, touching)), fresh.mean};
}

}  // namespace
}  // namespace palpate::bench

int main(int argc, char** argv) {
  using namespace palpate::bench;
  CLI::App app("Estimates what the machine could do, and how far the contact query is from it.", "limit");
  std::size_t gaussians = 1'000'000;
  ReportFiles files;
  app.add_option("--gaussians", gaussians, "size of the scene")->check(positive())->capture_default_str();
  declare_files(app, files);
  return run_program(app, argc, argv, [&] {
    const Limit limit = find_limit(gaussians);
    publish(palpate::machine() + "\n\n" + to_markdown(limit), files.markdown, to_json(limit), files.json);
  });
}

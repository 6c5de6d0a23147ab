// Cost of a query as the scene, the number of contacts, or the tool grows.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "program.h"
#include "report.h"
#include "scene_file.h"

namespace palpate::bench {
namespace {

/// Options with one quantity that grows, all others fixed.
struct Sweep {
  std::string quantity;
  std::vector<std::pair<std::string, ComparisonOptions>> steps{};

  void add(std::string value, const ComparisonOptions& options) {
    steps.emplace_back(std::move(value), options);
  }
};

Sweep over_gaussians(ComparisonOptions options, const std::vector<std::size_t>& sizes) {
  Sweep sweep{"Gaussians"};
  for (const std::size_t n : sizes) {
    options.gaussians = n;
    sweep.add(std::to_string(n), options);
  }
  return sweep;
}

/// A fixed number of Gaussians, of increasing density.
Sweep over_density(ComparisonOptions options) {
  Sweep sweep{"Gaussians a cm2"};
  for (const double per_cm2 : {1.0, 2.0, 4.0, 8.0, 16.0, 32.0}) {
    options.spacing = 0.01 / std::sqrt(per_cm2);
    sweep.add(fmt::format("{:g}", per_cm2), options);
  }
  return sweep;
}

/// The same centres, with increasingly large ellipsoids.
Sweep over_sigma(ComparisonOptions options) {
  Sweep sweep{"sigma"};
  for (const double sigma : {0.5, 1.0, 1.5, 2.0, 3.0}) {
    options.sigma = sigma;
    sweep.add(fmt::format("{:g}", sigma), options);
  }
  return sweep;
}

Sweep over_tool(ComparisonOptions options) {
  Sweep sweep{"tool length, mm"};
  for (const double factor : {0.125, 0.25, 0.5, 1.0, 2.0, 4.0}) {
    options.poses.tool = factor * kTool;
    sweep.add(fmt::format("{:g}", 2e3 * options.poses.tool.maxCoeff()), options);
  }
  return sweep;
}

/// The sweeps by their names on the command line.
std::map<std::string, Sweep> all_sweeps(const ComparisonOptions& options,
                                        const std::vector<std::size_t>& sizes) {
  return {{"gaussians", over_gaussians(options, sizes)},
          {"density", over_density(options)},
          {"sigma", over_sigma(options)},
          {"tool", over_tool(options)}};
}

std::string rows(const std::string& value, const Comparison& c) {
  std::string text;
  for (const PipelineResult& r : c.results) {
    text += fmt::format(
        "| {} | {:.1f} | {} | {} | {} | {} | {} | {:.2f} s | {:.0f} MB |\n", value, c.hits_per_contact_pose(),
        r.name, microseconds(r.contact.median), microseconds(r.contact.p999), microseconds(r.contact.mean),
        r.accuracy.misses + r.accuracy.extras, r.build_seconds, 1e-6 * static_cast<double>(r.bytes));
  }
  return text;
}

std::string head(const std::string& quantity) {
  return fmt::format(
      "\n| {} | contacts a pose | pipeline | median | p99.9 | mean | wrong verdicts | build | memory |\n"
      "|---|---|---|---|---|---|---|---|---|\n",
      quantity);
}

/// Runs a sweep; appends its table to `markdown` and its results to `json`.
void run(const Sweep& sweep, const std::vector<Family>& families, std::string& markdown,
         nlohmann::ordered_json& json) {
  markdown += head(sweep.quantity);
  for (const auto& [value, options] : sweep.steps) {
    const Comparison comparison = compare(options, families);
    markdown += rows(value, comparison);
    json[sweep.quantity].push_back(to_json(comparison));
  }
}

/// Measures a scene file; appends its costs and its table to `markdown`, and its results to `json`.
void run(const std::string& path, const ComparisonOptions& options, std::string& markdown,
         nlohmann::ordered_json& json) {
  const SceneFileResult file = measure_scene_file(path, options);
  markdown += to_markdown(file) + head("poses") + rows("1 kHz strokes", file.strokes) +
              rows("over the whole scene", file.whole_scene);
  json["file"] = to_json(file);
}

}  // namespace
}  // namespace palpate::bench

int main(int argc, char** argv) {
  using namespace palpate::bench;
  CLI::App app("Measures how the cost of a contact query grows.", "growth");
  ProgramOptions options;
  options.comparison.every_target = false;
  std::vector<std::size_t> sizes{10'000, 100'000, 1'000'000, 10'000'000};
  const std::vector<std::string> all{"gaussians", "density", "sigma", "tool"};
  std::vector<std::string> names = all;
  std::vector<std::string> with;
  app.add_option("--sweep", names, "what grows")->check(CLI::IsMember(all))->capture_default_str();
  app.add_option("--gaussians", sizes, "sizes of the scene; other sweeps are at 1000000")
      ->check(positive())
      ->capture_default_str();
  std::string scene;
  app.add_option("--scene", scene,
                 "instead: a file of make_bench_scene of the same seed, indexed and opened as a file")
      ->type_name("FILE.ply");
  app.add_option("--with", with, "peers to measure too")->check(CLI::IsMember(peer_names()));
  declare_options(app, options);

  return run_program(app, argc, argv, [&] {
    const std::vector<Family> selected = select_families(
        [&](const std::string& name) { return std::find(with.begin(), with.end(), name) != with.end(); });
    const std::map<std::string, Sweep> sweeps = all_sweeps(options.comparison, sizes);
    const std::string where = palpate::machine();
    std::string markdown = where + "\n";
    nlohmann::ordered_json json{{"machine", where}};
    if (!scene.empty()) {
      run(scene, options.comparison, markdown, json);
    } else {
      for (const std::string& name : names) run(sweeps.at(name), selected, markdown, json);
    }
    publish(markdown, options.files.markdown, json, options.files.json);
  });
}

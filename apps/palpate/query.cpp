// palpate query: one pose, its contacts and its wrench.
#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <palpate/haptics/tool_query.h>

#include "command.h"
#include "options.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

struct Options {
  CommonOptions common;
  SceneOptions scene;
  QueryOptions query;
  ForceOptions force;
  Pose pose;
};

/// Of the file that they are from, whatever index found them.
std::vector<Contact> ordered_by_id(std::vector<Contact> contacts) {
  std::sort(contacts.begin(), contacts.end(), [](const Contact& a, const Contact& b) { return a.id < b.id; });
  return contacts;
}

Json to_json(const ContactSet& set, const Wrench& wrench) {
  Json json{{"candidates", set.candidates}, {"filtered", set.filtered}, {"contacts", Json::array()}};
  for (const Contact& c : ordered_by_id(set.contacts)) {
    json["contacts"].push_back({{"id", c.id},
                                {"k_min", c.k_min},
                                {"lambda", c.lambda},
                                {"opacity", c.opacity},
                                {"center", vector_json(c.center)},
                                {"point", vector_json(c.point)},
                                {"normal", vector_json(c.normal)},
                                {"depth", c.depth}});
  }
  json["force"] = vector_json(wrench.force);
  json["torque"] = vector_json(wrench.torque);
  return json;
}

/// The deepest contacts first, as many as fit a screen.
void print_contacts(std::vector<Contact> contacts) {
  constexpr std::size_t kShown = 20;
  std::sort(contacts.begin(), contacts.end(),
            [](const Contact& a, const Contact& b) { return a.k_min > b.k_min; });
  if (contacts.empty()) return;
  fmt::print("\n{:>10} {:>8} {:>8} {:>8} {:>9}  {:<30} {}\n", "id", "K_min", "lambda", "opacity", "depth mm",
             "point m", "normal");
  for (std::size_t i = 0; i < std::min(kShown, contacts.size()); ++i) {
    const Contact& c = contacts[i];
    fmt::print("{:>10} {:>8.5f} {:>8.5f} {:>8.3f} {:>9.3f}  {:<30} {:.3f} {:.3f} {:.3f}\n", c.id, c.k_min,
               c.lambda, c.opacity, 1e3 * c.depth,
               fmt::format("{:.5f} {:.5f} {:.5f}", c.point.x(), c.point.y(), c.point.z()), c.normal.x(),
               c.normal.y(), c.normal.z());
  }
  if (contacts.size() > kShown) fmt::print("  ... and {} more; --json lists all\n", contacts.size() - kShown);
}

void print_text(const ContactSet& set, const Wrench& wrench, const std::string& model,
                const Options& options) {
  fmt::print("{} candidates, {} after the spheres, {} in contact\n", set.candidates, set.filtered,
             set.contacts.size());
  fmt::print("force  {:.4f} {:.4f} {:.4f} N, |F| = {:.4f} N ({})\n", wrench.force.x(), wrench.force.y(),
             wrench.force.z(), wrench.force.norm(), model);
  fmt::print("torque {:.5f} {:.5f} {:.5f} N m\n", wrench.torque.x(), wrench.torque.y(), wrench.torque.z());
  print_contacts(set.contacts);
  if (!options.common.quiet) notify("note: " + options.scene.frame_note());
}

void run(const Options& options) {
  const Progress progress = terminal_progress(options.common.quiet);
  const auto query = options.query.build(options.scene, progress);
  ContactSet set;
  palpate::query(*query, options.query.tool, options.pose, set);
  const auto model = options.force.build(*query, options.query.tool, options.scene.path, progress);
  const Wrench wrench = model->evaluate({options.pose, {}, 0.0, &set}).wrench;

  const auto* paper = dynamic_cast<const PaperPipeline*>(query.get());
  if (options.common.json) {
    Json json = to_json(set, wrench);
    if (paper != nullptr) add_reach(*paper, options.query.tool, json);
    fmt::print("{}\n", json.dump(2));
  } else {
    print_text(set, wrench, options.force.model_for(*query), options);
    if (paper != nullptr) print_reach(*paper, options.query.tool);
  }
}

}  // namespace

Command declare_query(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("query", "One pose: the contacts and the wrench");
  auto options = std::make_shared<Options>();
  declare_common(*app, options->common, "print contacts and wrench as JSON");
  options->scene.declare(*app, SceneOptions::As::kPositional);
  add_parsed(*app, "--pose", "x,y,z[,qw,qx,qy,qz]", "tool pose in the world, m",
             [options](const std::string& text) { options->pose = parse_pose(text); })
      ->required();
  options->query.declare_tool(*app);
  options->query.declare_pipeline(*app);
  options->force.declare(*app);
  return {app, [=] { run(*options); }};
}

}  // namespace palpate::cli

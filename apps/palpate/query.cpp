// palpate query: one pose, its contacts and its wrench.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <palpate/haptics/confidence.h>
#include <palpate/haptics/tool_query.h>

#include "command.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

struct Options {
  CommonOptions common;
  LiveConfig live;
  QueryOptions query;
  Pose pose;
};

/// One contact as it is shown.
struct Row {
  Contact contact;
  const std::string* part;  ///< of the tool
  double confidence;        ///< NaN where nobody asked
};

/// What there is to say about a pose.
struct Answer {
  std::size_t candidates, filtered;
  std::vector<Row> rows;
  ForceOutput felt;
};

Answer ask(const Options& options, const Pipeline& pipeline, ForceModel& model) {
  ContactSet set;
  const Tool& tool = options.live.tool;
  palpate::query(pipeline.query(), tool, options.pose, set);
  std::vector<double> confidences(set.contacts.size(), std::numeric_limits<double>::quiet_NaN());
  if (pipeline.index)
    confidences = confidence(*pipeline.index, tool, options.pose, options.live.force.proxy, set.contacts);
  Answer answer{set.candidates, set.filtered, {}, model.evaluate({options.pose, {}, 0.0, &set})};
  for (std::size_t i = 0; i < set.contacts.size(); ++i) {
    const Contact& contact = set.contacts[i];
    answer.rows.push_back({contact, &tool.parts()[contact.part].name, confidences[i]});
  }
  return answer;
}

Json to_json(Answer answer) {
  // Of the file that they are from, whatever index found them.
  std::stable_sort(answer.rows.begin(), answer.rows.end(),
                   [](const Row& a, const Row& b) { return a.contact.id < b.contact.id; });
  Json json{{"candidates", answer.candidates}, {"filtered", answer.filtered}, {"contacts", Json::array()}};
  for (const Row& row : answer.rows) {
    const Contact& c = row.contact;
    json["contacts"].push_back({{"id", c.id},
                                {"k_min", c.k_min},
                                {"lambda", c.lambda},
                                {"opacity", c.opacity},
                                {"center", vector_json(c.center)},
                                {"point", vector_json(c.point)},
                                {"normal", vector_json(c.normal)},
                                {"depth", c.depth},
                                {"part", *row.part},
                                {"confidence", row.confidence}});  // NaN is written as null
  }
  json["force"] = vector_json(answer.felt.wrench.force);
  json["torque"] = vector_json(answer.felt.wrench.torque);
  json["confidence"] = answer.felt.confidence;
  return json;
}

/// The deepest contacts first, as many as fit a screen.
void print_contacts(std::vector<Row> rows) {
  constexpr std::size_t kShown = 20;
  std::sort(rows.begin(), rows.end(),
            [](const Row& a, const Row& b) { return a.contact.k_min > b.contact.k_min; });
  if (rows.empty()) return;
  fmt::print("\n{:>10} {:>8} {:>8} {:>8} {:>9} {:>10}  {:<30} {}\n", "id", "K_min", "lambda", "opacity",
             "depth mm", "confidence", "point m", "normal");
  for (std::size_t i = 0; i < std::min(kShown, rows.size()); ++i) {
    const Contact& c = rows[i].contact;
    fmt::print("{:>10} {:>8.5f} {:>8.5f} {:>8.3f} {:>9.3f} {:>10}  {:<30} {:.3f} {:.3f} {:.3f}\n", c.id,
               c.k_min, c.lambda, c.opacity, 1e3 * c.depth,
               std::isnan(rows[i].confidence) ? "-" : fmt::format("{:.3f}", rows[i].confidence),
               fmt::format("{:.5f} {:.5f} {:.5f}", c.point.x(), c.point.y(), c.point.z()), c.normal.x(),
               c.normal.y(), c.normal.z());
  }
  if (rows.size() > kShown) fmt::print("  ... and {} more; --json lists all\n", rows.size() - kShown);
}

void print_text(const Answer& answer, const std::string& model, const Options& options) {
  const Wrench& wrench = answer.felt.wrench;
  fmt::print("{} candidates, {} after the spheres, {} in contact\n", answer.candidates, answer.filtered,
             answer.rows.size());
  fmt::print("force  {:.4f} {:.4f} {:.4f} N, |F| = {:.4f} N ({})\n", wrench.force.x(), wrench.force.y(),
             wrench.force.z(), wrench.force.norm(), model);
  fmt::print("torque {:.5f} {:.5f} {:.5f} N m\n", wrench.torque.x(), wrench.torque.y(), wrench.torque.z());
  print_contacts(answer.rows);
  if (!options.common.quiet) notify("note: " + options.live.scene.frame_note());
}

void run(const Options& options) {
  const Progress progress = terminal_progress(options.common.quiet);
  const Pipeline pipeline = options.query.build(options.live, progress);
  const auto model = options.query.build_model(options.live, pipeline, progress);
  const Answer answer = ask(options, pipeline, *model);

  if (options.common.json) {
    Json json = to_json(answer);
    if (pipeline.paper) add_reach(*pipeline.paper, options.live.tool, json);
    json["made"] = made_json(made_by(options.common, options.live, options.query, pipeline));
    print_json(json);
  } else {
    print_text(answer, std::string(to_string(options.query.model(options.live))), options);
    if (pipeline.paper) print_reach(*pipeline.paper, options.live.tool);
  }
}

}  // namespace

Command declare_query(CLI::App& parent) {
  CLI::App& app = add_command(parent, "query", "One pose: the contacts and the wrench");
  auto options = std::make_shared<Options>();
  declare_common(app, options->common, "print contacts and wrench as JSON");
  declare_scene(app, options->live, SceneArgument::kPositional);
  add_parsed(app, "--pose", "x,y,z[,qw,qx,qy,qz]", "tool pose in the world, m",
             [options](const std::string& text) { options->pose = parse_pose(text); })
      .required();
  declare_field(app, options->live, "tool");
  options->query.declare(app, options->live);
  declare_group(app, options->live, ConfigGroup::kForce);
  return {&app, [=] { run(*options); }};
}

}  // namespace palpate::cli

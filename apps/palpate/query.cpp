// palpate query: contacts and wrench at one pose.
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <palpate/haptics/confidence.h>
#include <palpate/haptics/settled_force.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/report/pose_table.h>

#include "command.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {
namespace {

struct QueryCommandOptions {
  CommonOptions common;
  LiveConfig live;
  QueryOptions query;
  Pose pose;
};

PoseReport ask(const QueryCommandOptions& options, const Pipeline& pipeline, ForceModel& model) {
  ContactSet set;
  const Tool& tool = options.live.tool;
  palpate::query(pipeline.query(), tool, options.pose, set);
  std::vector<double> confidences(set.contacts.size(), std::numeric_limits<double>::quiet_NaN());
  if (pipeline.index)
    confidences = confidence(*pipeline.index, tool, options.pose, options.live.force.proxy, set.contacts);
  PoseReport answer{set.candidates, set.filtered, {}, settled_force(model, options.pose, set)};
  for (std::size_t i = 0; i < set.contacts.size(); ++i) {
    const Contact& contact = set.contacts[i];
    answer.rows.push_back({contact, &tool.parts()[contact.part].name, confidences[i]});
  }
  return answer;
}

void run(const QueryCommandOptions& options) {
  const Progress progress = terminal_progress(options.common.quiet);
  const Pipeline pipeline = options.query.build(options.live, progress);
  const auto model = options.query.build_model(options.live, pipeline, progress);
  const PoseReport answer = ask(options, pipeline, *model);

  if (options.common.json) {
    Json json = pose_json(answer);
    if (pipeline.paper) add_reach(*pipeline.paper, options.live.tool, json);
    json["made"] = made_json(made_by(options.common, options.live, options.query, pipeline));
    print_json(json);
  } else {
    fmt::print("{}", pose_text(answer, to_string(options.query.model(options.live))));
    if (!options.common.quiet) notify("note: " + options.live.scene.frame_note());
    if (pipeline.paper) print_reach(*pipeline.paper, options.live.tool);
  }
}

}  // namespace

Command declare_query(CLI::App& parent) {
  CLI::App& app = add_command(
      parent, "query", "Contacts and wrench at one pose, where the tool rests until the force has settled");
  auto options = std::make_shared<QueryCommandOptions>();
  declare_common(app, options->common, "print contacts and wrench as JSON");
  declare_scene(app, options->live, SceneArgument::kPositional);
  add_parsed(app, "--pose", "x,y,z[,qw,qx,qy,qz]", "tool pose, world frame, m",
             [options](const std::string& text) { options->pose = parse_pose(text); })
      .required();
  declare_field(app, options->live, "tool");
  options->query.declare(app, options->live);
  declare_group(app, options->live, ConfigGroup::kForce);
  return {&app, [=] { run(*options); }};
}

}  // namespace palpate::cli

// palpate info: statistics of a scene file, lint findings, and the result of the filter.
#include <cstdio>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/live/setup_json.h>
#include <palpate/live/setup_text.h>
#include <palpate/report/scene_table.h>
#include <palpate/scene/lint.h>

#include "command.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {

Command declare_info(CLI::App& parent) {
  CLI::App& app =
      add_command(parent, "info",
                  "Counts, bounds, opacity and scale quantiles, lint findings and filter result of a scene");
  auto common = std::make_shared<CommonOptions>();
  auto live = std::make_shared<LiveConfig>();
  declare_common(app, *common, "print figures as JSON");
  declare_scene(app, *live, SceneArgument::kPositional);
  return {&app, [=] {
            const LoadedScene loaded = load(live->scene, terminal_progress(common->quiet));
            const LintReport findings = lint(loaded.scene);
            const SceneConfig& scene = live->scene;
            const SceneReport report{loaded.scene,
                                     loaded.kept,
                                     loaded.filtered,
                                     findings,
                                     scene.filter.opacity_min,
                                     scene.frame_note(),
                                     scene.registration.scale};
            std::optional<SceneSetup> setup;
            if (findings.defects[0] != 0) setup = propose_setup(loaded.scene, live->tool.thinnest());
            if (common->json) {
              Json json = scene_json(report);
              json["proposed"] = setup ? setup_json<Json>(*setup) : Json();
              json["made"] = made_json(made_by(*common, *live, {ConfigGroup::kScene}));
              print_json(json);
            } else {
              fmt::print("{}", scene_text(report));
              if (setup) fmt::print("{}", setup_text(*setup));
            }
          }};
}

}  // namespace palpate::cli

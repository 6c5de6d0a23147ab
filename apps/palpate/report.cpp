// palpate report: the paper's Fig. 5 and Fig. 4 of a run, as one self-contained page.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/live/run_origin.h>
#include <palpate/report/markup.h>
#include <palpate/report/report_data.h>
#include <palpate/report/result_files.h>
#include <palpate/report/run_figures.h>

#include "command.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "terminal.h"

extern "C" {
extern const char palpate_report_page_begin[];
extern const char palpate_report_page_end[];
}

namespace palpate::cli {
namespace {

struct ReportOptions {
  CommonOptions common;
  LiveConfig live;
  std::vector<std::string> runs;  ///< the first run, and those plotted over it
  RunWindow window;
  std::string out, svg;
};

/// Page template with its placeholders filled in, one of each kind.
std::string fill_page(const std::string& title, const std::string& json) {
  std::string page(palpate_report_page_begin, palpate_report_page_end);
  const auto fill = [&](std::string_view placeholder, const std::string& text) {
    page.replace(page.find(placeholder), placeholder.size(), text);
  };
  fill("<!--PALPATE_TITLE-->", markup_escaped(printable(title)));
  fill("<!--PALPATE_RUN_JSON-->", json);
  return page;
}

void warn_if_different(const RunContacts& contacts, const ReportOptions& options) {
  if (contacts.rows_differing == 0) return;
  notify(fmt::format(
      "warning: {}: {} of {} checked poses have other contacts in {}; give the replay's "
      "scene options and --tool",
      options.runs.front(), contacts.rows_differing, contacts.rows_checked, options.live.scene.path));
}

std::vector<Run> read_all(const ReportOptions& options, const Progress& progress) {
  std::vector<Run> all;
  for (const std::string& path : options.runs) {
    all.push_back(read_run(path, options.window, progress));
    if (all.back().cut)
      notify(fmt::format("{}: the last line is truncated and ignored (the recording was interrupted)", path));
  }
  return all;
}

void run(const ReportOptions& options) {
  check_output(options.out, {options.live.scene.path, options.common.config});
  check_output(options.out, options.runs);
  check_ending(options.out, ".html");
  check_figure_folder(options.svg);
  if (const std::string& first = options.runs.front();
      !options.live.scene.path.empty() && has_provenance(first))
    RunOrigin(first).check(options.live.scene);
  const Progress progress = terminal_progress(options.common.quiet);
  const std::vector<Run> runs = read_all(options, progress);
  const Run& recorded = runs.front();
  const std::span<const Run> others = std::span(runs).subspan(1);
  std::string json;
  if (options.live.scene.path.empty()) {
    json = report_json(recorded, nullptr, nullptr, nullptr, program_version(), others);
  } else {
    const LoadedScene loaded = load(options.live.scene, progress);
    const SceneIndex index(loaded.scene, options.live.scene.filter, options.live.scene.world_from_scene(),
                           progress);
    const RunContacts contacts = find_contacts(recorded, index, options.live.tool);
    warn_if_different(contacts, options);
    json = report_json(recorded, &loaded.kept, &options.live.tool, &contacts, program_version(), others);
  }
  const std::string title = std::filesystem::path(options.runs.front()).filename().string();
  write_file(options.out, fill_page(title, json));
  std::vector<std::string> written{options.out};
  if (!options.svg.empty()) write_figures(run_figures(runs), options.svg, "report", written);
  if (options.common.quiet) return;
  print_written(written);
}

void declare_window(CLI::App& app, RunWindow& window) {
  add_parsed(app, "--from", "S", "start of the time window, s on the run's clock",
             [&window](const std::string& text) { window.from = parse_number(text); });
  add_parsed(app, "--to", "S", "end of the time window, s on the run's clock",
             [&window](const std::string& text) {
               window.to = parse_number(text);
               if (window.to < window.from)
                 throw BadValue(fmt::format("{} is before --from {}", text, window.from));
             });
}

}  // namespace

std::string recording_page(const std::string& csv) {
  try {
    const std::string title = std::filesystem::path(csv).filename().string();
    return fill_page(title, report_json(read_run(csv), nullptr, nullptr, nullptr, program_version()));
  } catch (const std::exception& error) {  // including out of memory for a long recording
    return "<!doctype html><title>no report</title><p>" + markup_escaped(error.what());
  }
}

Command declare_report(CLI::App& parent) {
  CLI::App& app = add_command(parent, "report", "Interactive, self-contained page of a run");
  auto options = std::make_shared<ReportOptions>();
  declare_common(app, options->common);
  add_files(app, "RUN.csv", options->runs,
            "output of replay, or a recording; with --scene, its settings apply unless options override "
            "them; further runs are plotted over the first, each on its own clock")
      .required();
  add_text(app, "--out,--html", options->out, "R.html", "output file of the page").required();
  add_text(app, "--svg", options->svg, "DIR",
           "existing folder for figures of counts, forces and times as SVG files");
  declare_window(app, options->window);
  declare_scene(app, options->live, SceneArgument::kOption);
  declare_field(app, options->live, "tool");
  return {&app, [=] { run(*options); }};
}

}  // namespace palpate::cli

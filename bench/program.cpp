#include "program.h"

#include <algorithm>
#include <exception>

#include <fmt/core.h>

namespace palpate::bench {

CLI::Validator positive() {
  const auto check = [](std::string& text) {
    double value = 0.0;
    const bool good = CLI::detail::lexical_cast(text, value) && value > 0.0;
    return good ? std::string() : fmt::format("'{}' is not a positive number", text);
  };
  return {check, "POSITIVE"};
}

void declare_files(CLI::App& app, ReportFiles& files) {
  app.add_option("--json", files.json, "file to write the results to")->type_name("FILE");
  app.add_option("--markdown", files.markdown, "file to write the table to")->type_name("FILE");
}

void declare_options(CLI::App& app, ProgramOptions& options) {
  ComparisonOptions& c = options.comparison;
  app.add_option("--sigma", c.sigma, "ellipsoid of a Gaussian, in standard deviations")
      ->check(positive())
      ->capture_default_str();
  app.add_option("--poses", c.poses.count, "number of poses")->check(positive())->capture_default_str();
  app.add_option("--seed", c.poses.seed, "of scene and poses")->capture_default_str();
  app.add_flag("--shuffle", c.poses.shuffle, "the same poses in random order");
  app.add_flag("--whole-scene", c.poses.whole_scene, "every pose somewhere else in the scene");
  app.add_option("--rounds", c.rounds, "passes over the poses; the least time of each pose counts")
      ->check(positive())
      ->capture_default_str();
  app.add_option(
         "--search-radius", c.search_radius,
         "of the paper's kd-tree in m; by default it reaches all but the largest 1 % of the Gaussians")
      ->check(positive());
  declare_files(app, options.files);
}

std::vector<std::string> peer_names() {
  std::vector<std::string> names;
  for (const Family& family : families())
    if (family.peer) names.emplace_back(family.name);
  return names;
}

std::vector<Family> select_families(const std::function<bool(const std::string&)>& wanted) {
  std::vector<Family> selected;
  for (const Family& family : families())
    if (!family.peer || wanted(std::string(family.name))) selected.push_back(family);
  return selected;
}

int run_program(CLI::App& app, int argc, char** argv, const std::function<void()>& body) {
  try {
    app.parse(argc, argv);
    body();
    return 0;
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", app.help());
    return 0;
  } catch (const CLI::ParseError& error) {
    std::string message = error.what();
    std::replace(message.begin(), message.end(), '\n', ' ');
    fmt::print(stderr, "{}: {} (see --help)\n", app.get_name(), message);
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", app.get_name(), error.what());
    return 1;
  }
}

}  // namespace palpate::bench

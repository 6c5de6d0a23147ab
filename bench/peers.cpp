// This library, the paper's pipeline and three collision libraries on one scene, in one run.
#include <algorithm>

#include "program.h"
#include "report.h"

#include <nlohmann/json.hpp>

int main(int argc, char** argv) {
  using namespace palpate::bench;
  CLI::App app("Compares the contact query with the paper's pipeline, FCL, Bullet and Embree.", "peers");
  ProgramOptions options;
  app.add_option("--gaussians", options.comparison.gaussians, "size of the scene")
      ->check(positive())
      ->capture_default_str();
  std::vector<std::string> without;
  app.add_option("--without", without, "peers to leave out")->check(CLI::IsMember(peer_names()));
  declare_options(app, options);

  return run_program(app, argc, argv, [&] {
    const auto wanted = [&](const std::string& name) {
      return std::find(without.begin(), without.end(), name) == without.end();
    };
    const Comparison comparison = compare(options.comparison, select_families(wanted));
    nlohmann::ordered_json json = to_json(comparison);
    json["machine"] = palpate::machine();
    publish(palpate::machine() + "\n\n" + to_markdown(comparison), options.files.markdown, json,
            options.files.json);
  });
}

#include "made.h"

#include <utility>

#include <fmt/format.h>

#include <palpate/base/csv.h>

#include "declare.h"

namespace palpate::cli {

Provenance made_by(const CommonOptions& common, const LiveConfig& live,
                   std::initializer_list<ConfigGroup> groups) {
  return made_by(common, scene_origin(live.scene), live, groups);
}

Provenance made_by(const CommonOptions& common, const SceneOrigin& scene, const LiveConfig& live,
                   std::initializer_list<ConfigGroup> groups) {
  Provenance known = provenance(command_name(*common.app), scene, live, groups);
  for (const auto& [name, text] : other_options(*common.app)) set_text(known, name, text);
  return known;
}

Provenance made_by(const CommonOptions& common, LiveConfig live, const QueryOptions& query_options,
                   const Pipeline& pipeline) {
  using enum ConfigGroup;
  live.force.model = query_options.model(live);
  Provenance known = made_by(common, live, {kScene, kTool, kForce});
  if (pipeline.paper) set(known, "search-radius", fmt::format("{}", pipeline.paper->search_radius()));
  return known;
}

std::string head_of(const Provenance& provenance) { return csv_comment(to_toml(provenance)); }

Json with_made(const Provenance& provenance, Json rows) {
  return {{"made", made_json(provenance)}, {"rows", std::move(rows)}};
}

}  // namespace palpate::cli

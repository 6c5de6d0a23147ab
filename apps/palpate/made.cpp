#include "made.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/csv.h>

#include "declare.h"

namespace palpate::cli {
namespace {

/// A value of TOML: most are JSON, too; a literal of many lines is text.
Json value_json(const std::string& value) {
  constexpr std::string_view kLiteral = "'''";
  if (Json::accept(value)) return Json::parse(value);
  std::string_view text = value;
  if (text.starts_with(kLiteral)) {
    text.remove_prefix(kLiteral.size() + 1);  // with its first line break, which is no part of it
    text.remove_suffix(kLiteral.size());
  }
  return text;
}

/// As it is where that is a number, true or false to TOML, too; else as text.
std::string toml_value(const std::string& text) {
  if (!Json::accept(text)) return toml_quoted(text);
  const Json value = Json::parse(text);
  const bool too_large = value.is_number_unsigned() &&
                         value.get<std::uint64_t>() > std::uint64_t{std::numeric_limits<std::int64_t>::max()};
  return value.is_boolean() || (value.is_number() && !too_large) ? text : toml_quoted(text);
}

}  // namespace

Provenance made_by(const CommonOptions& common, const LiveConfig& live,
                   std::initializer_list<ConfigGroup> groups) {
  return made_by(common, scene_origin(live.scene), live, groups);
}

Provenance made_by(const CommonOptions& common, const SceneOrigin& scene, const LiveConfig& live,
                   std::initializer_list<ConfigGroup> groups) {
  Provenance known = provenance(command_name(*common.app), scene, live, groups);
  for (const auto& [name, text] : other_options(*common.app)) set(known, name, toml_value(text));
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

void set(Provenance& provenance, std::string_view name, const std::string& value) {
  std::vector<SettingText>& all = provenance.settings;
  const auto at = std::find_if(all.begin(), all.end(), [&](const SettingText& s) { return s.name == name; });
  if (at != all.end()) {
    at->value = value;
  } else {
    all.push_back({std::string(name), value});
  }
}

std::string head_of(const Provenance& provenance) { return csv_comment(to_toml(provenance)); }

Json made_json(const Provenance& provenance) {
  Json json, settings = Json::object();
  for (const SettingText& item : provenance.made) {
    std::string name = item.name;
    std::replace(name.begin(), name.end(), '-', '_');
    json[name] = value_json(item.value);
  }
  for (const SettingText& item : provenance.settings) settings[item.name] = value_json(item.value);
  json["settings"] = std::move(settings);
  return json;
}

Json with_made(const Provenance& provenance, Json rows) {
  return {{"made", made_json(provenance)}, {"rows", std::move(rows)}};
}

}  // namespace palpate::cli

/// \file
/// JSON form of a Provenance.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include <palpate/live/provenance.h>

namespace palpate {

/// Converts a TOML value to JSON: most are valid JSON; a multi-line literal becomes a string.
template <typename J>
J value_json(const std::string& value) {
  constexpr std::string_view kLiteral = "'''";
  if (J::accept(value)) return J::parse(value);
  std::string_view text = value;
  if (text.starts_with(kLiteral)) {
    text.remove_prefix(kLiteral.size() + 1);  // and the first line break, which TOML drops
    text.remove_suffix(kLiteral.size());
  }
  return text;
}

/// Returns an object with Provenance::made by name, and the object `settings`. \tparam J Json or OrderedJson
template <typename J>
J provenance_json(const Provenance& provenance) {
  J json, settings = J::object();
  for (const SettingText& item : provenance.made) {
    std::string name = item.name;
    std::replace(name.begin(), name.end(), '-', '_');
    json[name] = value_json<J>(item.value);
  }
  for (const SettingText& item : provenance.settings) settings[item.name] = value_json<J>(item.value);
  json["settings"] = std::move(settings);
  return json;
}

}  // namespace palpate

/// \file
/// Provenance of the results of a command.
#pragma once

#include <initializer_list>
#include <string>

#include <palpate/live/provenance.h>
#include <palpate/live/provenance_json.h>

#include "command.h"
#include "options.h"
#include "output.h"

namespace palpate::cli {

/// Provenance of a command: the fields of `live` in these groups, and its other options that affect results.
/// \throws Error if the scene or the materials cannot be read.
Provenance made_by(const CommonOptions& common, const LiveConfig& live,
                   std::initializer_list<ConfigGroup> groups);
/// The same, for a scene that is not the file of `live`.
Provenance made_by(const CommonOptions& common, const SceneOrigin& scene, const LiveConfig& live,
                   std::initializer_list<ConfigGroup> groups);

/// Provenance of a command that queries poses with `pipeline`, which was built from `query_options`.
Provenance made_by(const CommonOptions& common, LiveConfig live, const QueryOptions& query_options,
                   const Pipeline& pipeline);

/// Provenance as the comment header of a CSV file.
std::string head_of(const Provenance& provenance);

/// Provenance as JSON.
inline Json made_json(const Provenance& provenance) { return provenance_json<Json>(provenance); }

/// JSON object with the members `made` and `rows`.
Json with_made(const Provenance& provenance, Json rows);

}  // namespace palpate::cli

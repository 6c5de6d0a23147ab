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

/// Of a command whose fields of `live` are of these groups; its other options that decide a result are among
/// the settings. \throws Error if the scene or the materials cannot be read.
Provenance made_by(const CommonOptions& common, const LiveConfig& live,
                   std::initializer_list<ConfigGroup> groups);
/// The same with a scene that is no file of `live`.
Provenance made_by(const CommonOptions& common, const SceneOrigin& scene, const LiveConfig& live,
                   std::initializer_list<ConfigGroup> groups);

/// Of a command that asks poses, for the contacts of `pipeline`, which query_options made.
Provenance made_by(const CommonOptions& common, LiveConfig live, const QueryOptions& query_options,
                   const Pipeline& pipeline);

/// The head of a table in CSV.
std::string head_of(const Provenance& provenance);

/// Provenance as JSON.
inline Json made_json(const Provenance& provenance) { return provenance_json<Json>(provenance); }

/// An object of `made` and `rows`.
Json with_made(const Provenance& provenance, Json rows);

}  // namespace palpate::cli

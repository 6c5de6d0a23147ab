/// \file
/// What a live system is set to, as JSON and as a configuration file.
#pragma once

#include <palpate/rosbridge/message.h>

#include "live_system.h"

namespace palpate::cli {

/// JSON of clients; the command line's own keeps its order.
using Value = palpate::Json;

/// All settings, under the names that clients know them by.
Value settings_json(const LiveSettings& settings);

/// Changes `settings` by what `wanted` has of the same names. \throws Refusal, having changed nothing that
/// counts, for an unknown name or a value out of range.
void change_settings(LiveSettings& settings, const Value& wanted);

/// A file for --config that begins with these settings.
std::string settings_toml(const LiveSettings& settings);

}  // namespace palpate::cli

/// \file
/// Settings of a live system as JSON, as clients of the gateway and of the nodes on ROS see and change them.
#pragma once

#include <palpate/live/live_config.h>
#include <palpate/rosbridge/message.h>

namespace palpate {

/// All fields that are parameters, under the names that clients know them by.
Json settings_json(const LiveConfig& config);

/// Changes `config` by what `wanted` has of the same names. \throws Refusal, having changed nothing that
/// counts, for an unknown name or a value out of range.
void change_settings(LiveConfig& config, const Json& wanted);

}  // namespace palpate

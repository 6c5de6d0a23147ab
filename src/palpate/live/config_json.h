/// \file
/// JSON form of the settings of a live system, for clients of the gateway and of the ROS nodes.
#pragma once

#include <palpate/live/live_config.h>
#include <palpate/rosbridge/message.h>

namespace palpate {

/// Returns all fields that are parameters, under their parameter names.
Json settings_json(const LiveConfig& config);

/// Sets the fields of `config` that are named in `wanted`. \throws Refusal for an unknown name or a value out
/// of range; `config` is then to be discarded.
void change_settings(LiveConfig& config, const Json& wanted);

}  // namespace palpate

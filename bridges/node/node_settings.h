/// \file
/// Parameters of a node.
#pragma once

#include <string>
#include <vector>

#include <palpate/gateway/crtk_options.h>
#include <palpate/live/live_config.h>

#include "node_parameter.h"

namespace palpate::node {

/// What a node is told of a hand.
struct NodeHand {
  std::string name;  ///< empty: the first
  LiveConfig live;   ///< scene and gateway are those of the first
  CrtkArguments device;
  std::string device_frame = {};  ///< of tf, where the device's base is in the world
};

/// What a node is told when it starts.
struct NodeSettings {
  std::vector<NodeHand> hands;         ///< the first, then others
  bool hands_touch = false;            ///< they feel each other's tools
  int decimation = 1;                  ///< of the centres, every how manieth is published
  std::string world_frame = "world";   ///< frame_id of what is in the world
  std::string tf_prefix = "palpate/";  ///< of the names of all other frames of tf
  std::vector<std::string> scenes;     ///< folders whose scenes are offered, of a SceneLibrary
  std::string recordings = ".";        ///< folder for them
};

/// From these parameters, all of which may be missing or empty:
///
///     scene             file; the built-in scene
///     config            TOML file, as of `palpate run --config`
///     device            text of parse_crtk_arguments() (that of `config`, else /omni)
///     cloud_decimation  NodeSettings::decimation
///     hands             text of read_hands(), with commas between
///     scenes            folders, with commas between
///     world_frame, device_frame, tf_prefix, hands_touch, recordings
///
/// and the settings of scene, tool, force, loop and workspace under the names of config_fields(), `_` for
/// `-`, which go before those of `config`. Those of a hand, but for the scene's, and its `device` (that of
/// its file, else /NAME) and `device_frame` have its name before: "left/stiffness", or "left.stiffness" as
/// ROS 2 writes it. \param kind "ros1": which devices, and for messages \throws Error that names the
/// parameter, for an unknown one too.
NodeSettings read_node_settings(const std::string& kind, std::vector<NodeParameter> parameters);

}  // namespace palpate::node

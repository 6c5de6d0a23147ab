/// \file
/// Parameters of a node.
#pragma once

#include <string>
#include <vector>

#include <palpate/gateway/crtk_options.h>
#include <palpate/live/live_config.h>

#include "node_parameter.h"

namespace palpate::node {

/// Settings of a hand of a node.
struct NodeHand {
  std::string name;  ///< empty for the first hand
  LiveConfig live;   ///< scene and gateway are those of the first hand
  CrtkArguments device;
  std::string device_frame = {};  ///< tf frame of the device's base
};

/// Settings of a node at its start.
struct NodeSettings {
  std::vector<NodeHand> hands;         ///< the first hand, then the additional ones
  bool hands_touch = false;            ///< render contact forces between the tools of the hands
  int decimation = 1;                  ///< every n-th Gaussian centre is published
  std::string world_frame = "world";   ///< frame_id of data in the world frame
  std::string tf_prefix = "palpate/";  ///< prefix of the names of all other tf frames
  std::vector<std::string> scenes;     ///< folders of scenes to offer, for SceneLibrary
  std::string recordings = ".";        ///< output folder of recordings
};

/// Reads the settings from parameters, each of which may be missing or empty:
///
///     scene             scene file (default: the built-in scene)
///     config            TOML file, as for `palpate run --config`
///     device            text of parse_crtk_arguments() (default: the device of `config`, else /omni)
///     cloud_decimation  NodeSettings::decimation
///     hands             texts of read_hands(), separated by commas
///     scenes            folders, separated by commas
///     world_frame, device_frame, tf_prefix, hands_touch, recordings
///
/// and the settings of scene, tool, force, loop and workspace, named as in config_fields() with `_` for `-`;
/// they override those of `config`. Parameters of an additional hand (all settings but the scene's, `device`,
/// by default that of its file, else /NAME, and `device_frame`) have its name as prefix: "left/stiffness", or
/// "left.stiffness" as in ROS 2. \param kind prefix of device drivers in files: "ros1" or "ros2"
/// \throws Error that names the parameter, also for an unknown one.
NodeSettings read_node_settings(const std::string& kind, std::vector<NodeParameter> parameters);

}  // namespace palpate::node

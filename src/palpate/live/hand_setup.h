/// \file
/// Names and configurations of several hands.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/live/live_config.h>
#include <palpate/servo/haptic_device.h>

namespace palpate {

/// Setup of one hand of LiveHands.
struct HandSetup {
  std::string name;  ///< used in its topic names; empty for the first
  LiveConfig config;
  std::unique_ptr<HapticDevice> device = nullptr;  ///< the caller's own; null: one of `config`
};

/// Maximum length of a hand's name.
inline constexpr std::size_t kLongestHandName = 32;
/// Maximum number of hands in one process; topics, threads and terminal lines are designed for it.
inline constexpr std::size_t kMostHands = 64;

/// Returns why `name` is not a valid hand name; empty if it is valid. Topics are /palpate/NAME/..., so a name
/// must follow ROS's rules ([a-z][a-z0-9_]*) and not equal a topic, service or parameter of the first hand.
std::string hand_name_problem(std::string_view name);

/// Creates hand setups from "NAME=FILE.toml", or "NAME" for a hand configured like the first. FILE.toml is a
/// --config file whose settings override those of `first`; it must not set the scene or the gateway, which
/// are shared. \param where source of the texts, for error messages \throws Error for a duplicate or invalid
/// name, and as read_live_config().
std::vector<HandSetup> read_hands(const std::vector<std::string>& texts, const LiveConfig& first,
                                  std::string_view where = "--hands");

}  // namespace palpate

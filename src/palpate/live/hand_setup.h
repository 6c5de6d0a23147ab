/// \file
/// What a hand of several is called, and how it differs from the first.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/live/live_config.h>
#include <palpate/servo/haptic_device.h>

namespace palpate {

/// A hand that is to be: see LiveHands.
struct HandSetup {
  std::string name;  ///< of its topics; the first has none
  LiveConfig config;
  std::unique_ptr<HapticDevice> device = nullptr;  ///< the caller's own; null: one of `config`
};

/// Longest name of a hand.
inline constexpr std::size_t kLongestHandName = 32;
/// Most hands in one process: what their topics, threads and lines on a terminal are for.
inline constexpr std::size_t kMostHands = 64;

/// Why a hand cannot be called that: its topics are /palpate/NAME/..., so that it follows ROS's rules for
/// names ([a-z][a-z0-9_]*) and is not the name of a topic, service or parameter of the first hand. Empty: it
/// can.
std::string hand_name_problem(std::string_view name);

/// Sets up hands from "NAME=FILE.toml", or "NAME" for one that is as the first. A file is one for --config
/// whose settings replace those of `first`; scene and gateway are not among them, of which there is one.
/// \param where they are written, for messages \throws Error for a name that is taken or cannot be, and as
/// read_live_config().
std::vector<HandSetup> read_hands(const std::vector<std::string>& texts, const LiveConfig& first,
                                  std::string_view where = "--hands");

}  // namespace palpate

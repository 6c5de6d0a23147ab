#include <palpate/live/hand_setup.h>

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/live/config_toml.h>

namespace palpate {
namespace {

/// Names after "/palpate/" of the first hand's topics, services and parameters. A test compares them with
/// those of a gateway.
constexpr std::array<std::string_view, 45> kTaken{
    "measured_cp",    "measured_cv",    "spatial",    "body",         "proxy_cp",      "contacts",
    "tool",           "diagnostics",    "parameters", "messages",     "client",        "hands",
    "set_parameters", "get_parameters", "set_model",  "load_tool",    "pause",         "emergency_stop",
    "resume",         "clutch",         "demo",       "list_scenes",  "open_scene",    "propose_setup",
    "record",         "config",         "scene",      "registration", "filter",        "felt",
    "model",          "models",         "frames",     "stiffness",    "stiffness_max", "friction",
    "detail",         "device",         "room",       "paused",       "recording",     "recorded",
    "busy",           "message",        "hand"};

bool is_letter(char c) { return c >= 'a' && c <= 'z'; }
bool may_follow(char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_'; }

/// Returns whether the hands share the settings of a group, which only the first hand may set.
bool is_shared(ConfigGroup group) { return group == ConfigGroup::kScene || group == ConfigGroup::kGateway; }

}  // namespace

std::string hand_name_problem(std::string_view name) {
  if (name.empty() || name.size() > kLongestHandName || !is_letter(name[0]) ||
      !std::all_of(name.begin(), name.end(), may_follow))
    return fmt::format(
        "must begin with a lower-case letter and have only lower-case letters, digits and _, {} characters "
        "at most",
        kLongestHandName);
  if (std::find(kTaken.begin(), kTaken.end(), name) != kTaken.end())
    return fmt::format("is already used by /palpate/{}", name);
  return {};
}

std::vector<HandSetup> read_hands(const std::vector<std::string>& texts, const LiveConfig& first,
                                  std::string_view where) {
  if (texts.size() >= kMostHands) throw Error("{}: {} hands at most, including the first", where, kMostHands);
  std::vector<HandSetup> hands;
  for (const std::string& text : texts) {
    const std::size_t end = text.find('=');
    const std::string name = text.substr(0, end);
    if (const std::string problem = hand_name_problem(name); !problem.empty())
      throw Error("{}: '{}' {}", where, printable(name), problem);
    if (std::any_of(hands.begin(), hands.end(), [&](const HandSetup& hand) { return hand.name == name; }))
      throw Error("{}: there are two hands called '{}'", where, name);
    HandSetup& hand = hands.emplace_back();
    hand.name = name;
    hand.config = end == std::string::npos ? first : read_live_config(text.substr(end + 1), first, is_shared);
  }
  return hands;
}

}  // namespace palpate

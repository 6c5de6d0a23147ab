#include <palpate/live/live_hands.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/scene/load_scene.h>
#include <palpate/scene/scene_reader.h>

namespace palpate {
namespace {

/// Runs `work` for a hand; its errors get the name of the hand.
template <class Work>
void for_hand(const std::string& name, const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    throw Error("{}{}", said_of(name), error.what());
  }
}

/// Runs `work` for all hands; if it fails for one, stops all.
template <class Work>
void for_all_or_stop(LiveHands& hands, const Work& work) {
  try {
    for (std::size_t k = 0; k < hands.all().size(); ++k)
      for_hand(hands.all()[k].name, [&] { work(*hands.all()[k].system, k); });
  } catch (...) {
    hands.stop();
    throw;
  }
}

/// Returns `notify` with the name of a hand inserted into each line, after the kind of line.
Notify notify_of(const std::string& name, const Notify& notify) {
  if (name.empty() || !notify) return notify;
  return [name, notify](const std::string& line) {
    constexpr std::array<std::string_view, 2> kKinds{"note: ", "warning: "};
    std::size_t at = 0;
    for (const std::string_view kind : kKinds)
      if (line.starts_with(kind)) at = kind.size();
    notify(line.substr(0, at) + said_of(name) + line.substr(at));
  };
}

}  // namespace

std::string said_of(const std::string& hand) { return hand.empty() ? std::string() : "hand " + hand + ": "; }

LiveHands::LiveHands(std::vector<HandSetup> setups, const Notify& notify, const Progress& progress,
                     bool touch_each_other) {
  if (touch_each_other) touch_.emplace(setups.size());
  for (HandSetup& setup : setups) {
    for_hand(setup.name, [&] {
      const Notify tell = notify_of(setup.name, notify);
      auto system =
          hands_.empty()
              ? std::make_unique<LiveSystem>(setup.config, std::move(setup.device), tell, progress)
              : std::make_unique<LiveSystem>(setup.config, first().scene(), std::move(setup.device), tell);
      if (touch_) system->touch_others(*touch_, hands_.size());
      hands_.push_back({setup.name, std::move(system)});
    });
  }
  first().on_scene = [this](const SharedScene& scene) {
    for (const Hand& hand : all().subspan(1)) hand.system->follow(scene);
  };
}

LiveHands::~LiveHands() { stop(); }

void LiveHands::enable() {
  for_all_or_stop(*this, [](LiveSystem& system, std::size_t) { system.enable(); });
}

void LiveHands::start(const std::vector<std::vector<TickObserver*>>& observers) {
  enable();
  for_all_or_stop(*this, [&](LiveSystem& system, std::size_t k) { system.start(observers[k]); });
}

void LiveHands::stop() {
  stop_force(Fault::kEnded);
  for (const Hand& hand : hands_) hand.system->stop();  // the first one first: none follows it any more
}

std::string LiveHands::left_devices() const {
  std::string left;
  for (const Hand& hand : hands_) {
    if (hand.system->has_left_device())
      left += fmt::format(
          "{}{}the driver of {} does not return; its motors were told to stop, and it is not closed",
          left.empty() ? "" : "; ", said_of(hand.name), hand.system->device().name);
  }
  return left;
}

double LiveHands::playback_length() const {
  double longest = 0.0;
  for (const Hand& hand : hands_) {
    const double length = hand.system->playback_length();
    if (length == 0.0) return std::numeric_limits<double>::infinity();
    longest = std::max(longest, length);
  }
  return longest;
}

void LiveHands::stop_force(Fault why) {
  for (const Hand& hand : hands_) hand.system->stop_force(why);
}

void LiveHands::open_scene(const std::string& path) {
  for (const Hand& hand : all().subspan(1)) {
    if (const auto why = hand.system->needs_its_scene(); !why.empty())
      throw Error("{}{}; restart with the other scene", said_of(hand.name), why);
  }
  if (!path.empty()) palpate::open_scene(path);  // throws for an invalid scene, keeping the present one
  first().open_scene(path);
}

bool LiveHands::is_changing_scene() const {
  const SceneConfig wanted = first().settings().scene;
  return std::any_of(hands_.begin(), hands_.end(), [&](const Hand& hand) {
    const SceneConfig active = hand.system->scene().config;
    return active.path != wanted.path || active.world_from_scene() != wanted.world_from_scene();
  });
}

bool LiveHands::uses_world() const {
  return std::any_of(hands_.begin(), hands_.end(),
                     [](const Hand& hand) { return hand.system->uses_world(); });
}

}  // namespace palpate

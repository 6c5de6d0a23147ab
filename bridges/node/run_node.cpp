#include "run_node.h"

#include <algorithm>
#include <deque>
#include <exception>
#include <filesystem>
#include <new>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/base/real_time.h>
#include <palpate/live/config_json.h>
#include <palpate/live/config_toml.h>
#include <palpate/live/live_hands.h>
#include <palpate/live/run_signals.h>
#include <palpate/servo/live_view.h>

#include "live_show.h"
#include "node_recording.h"
#include "node_scenes.h"
#include "scene_show.h"

namespace palpate::node {
namespace {

/// Parts of a hand besides its live system.
struct HandParts {
  const NodeHand& settings;
  NodeNotices& notices;
  const CrtkDevice* device;
  std::unique_ptr<LiveView> view = std::make_unique<LiveView>();
  std::unique_ptr<NodeRecording> recording = {};
};

/// Parts of the node that its services use.
struct NodeParts {
  LiveHands& hands;
  NodeScenes& scenes;
  std::vector<HandParts>& of_hands;

  bool is_recording() const {
    return std::any_of(of_hands.begin(), of_hands.end(),
                       [](const HandParts& hand) { return hand.recording->is_under_way(); });
  }
};

/// Ramps the forces down before its owner's other members are destroyed, which may take long, also when an
/// exception is thrown.
class FallFirst {
 public:
  explicit FallFirst(LiveHands& hands) : hands_(hands) {}
  ~FallFirst() { hands_.stop_force(Fault::kEnded); }
  FallFirst(const FallFirst&) = delete;
  FallFirst& operator=(const FallFirst&) = delete;

 private:
  LiveHands& hands_;
};

/// Ends the recordings once the loops have ended, and says what has failed in them until then.
class RecordingsEnd {
 public:
  explicit RecordingsEnd(const std::vector<HandParts>& hands) : hands_(hands) {}
  ~RecordingsEnd() {
    for (const HandParts& hand : hands_) {
      try {
        if (const std::string said = hand.recording->close(); !said.empty()) hand.notices.say(said);
      } catch (const std::exception&) {  // not enough memory to say it
      }
    }
  }
  RecordingsEnd(const RecordingsEnd&) = delete;
  RecordingsEnd& operator=(const RecordingsEnd&) = delete;

 private:
  const std::vector<HandParts>& hands_;
};

/// Runs `work`; reports an exception as a one-line notice.
void say_refusal(NodeNotices& notices, const char* what, const std::function<void()>& work) {
  try {
    work();
  } catch (const std::exception& error) {
    notices.say(fmt::format("{}: {}", what, error.what()));
  }
}

std::string parameters(const LiveSystem& system, const NodeRecording& recording) {
  Json json = settings_json(system.settings());
  json["scene"] = {{"name", std::filesystem::path(felt_name(system)).filename().string()},
                   {"path", system.felt()->path()}};
  json["recording"] = recording.path();
  json["busy"] = system.busy();
  json["message"] = system.message();
  return encode_json(json);
}

/// Adds the services that may block. They run one at a time, on one thread.
void add_slow_services(NodeServices& services, const NodeParts& node, const HandParts& hand, bool first) {
  services.record = [&node, &recording = *hand.recording](bool on) {
    // Once it is under way: set_parameters refuses another placement only from then on.
    return recording.set(on, [&node] {
      if (node.hands.is_changing_scene())
        throw Error("the scene is being changed; start the recording when that is done");
    });
  };
  if (!first) return;
  services.list_scenes = [&node] { return node.scenes.list(); };
  services.open_scene = [&node, &notices = hand.notices](const std::string& which) {
    say_refusal(notices, "open_scene", [&] {
      if (node.is_recording()) throw Error("a recording contains one scene only; stop it first");
      node.scenes.open(which);
    });
  };
}

/// Services of hand `of`. The emergency stop of the first hand stops all hands.
NodeServices services_of(const NodeParts& node, const LiveHands::Hand& of, const HandParts& hand) {
  LiveSystem& system = *of.system;
  NodeServices services;
  services.emergency_stop = [&hands = node.hands, &system, all = of.name.empty()] {
    all ? hands.stop_force() : system.stop_force();
  };
  services.resume = [&system] { system.resume(); };
  services.pause = [&system](bool on) {
    on ? system.stop_force(Fault::kPaused) : system.tick().governor().unpause();
  };
  services.clutch = [&system](bool on) { system.tick().press_clutch(on); };
  services.get_parameters = [&system, &recording = *hand.recording] { return parameters(system, recording); };
  services.config = [&system, first = of.name.empty()] {
    return to_toml(system.settings(), first ? TomlFields::kSaved : TomlFields::kSavedOfHand);
  };
  services.set_parameters = [&node, &system, &notices = hand.notices](const std::string& json) {
    say_refusal(notices, "set_parameters", [&] {
      const Json wanted = decode_json(json);
      system.change([&](LiveConfig& settings) {
        const Similarity placed = settings.scene.world_from_scene();
        change_settings(settings, wanted);
        if (node.is_recording() && settings.scene.world_from_scene() != placed)
          throw Error("a recording states one placement of the scene; stop it first");
      });
    });
  };
  add_slow_services(services, node, hand, of.name.empty());
  return services;
}

std::vector<SinkHand> sink_hands(const NodeParts& node) {
  std::vector<SinkHand> all(node.of_hands.size());
  for (std::size_t k = 0; k < all.size(); ++k) {
    const LiveHands::Hand& hand = node.hands.all()[k];
    all[k] = {hand.name.empty() ? "palpate" : "palpate/" + hand.name,
              services_of(node, hand, node.of_hands[k])};
  }
  return all;
}

/// Publishes the hands and provides their services until the node ends; the forces then fall.
void serve(const NodeSettings& settings, const NodeNetwork& network, const NodeParts& node,
           const std::vector<LiveSystem*>& systems, NodeNotices& notices) {
  const auto sink = network.sink(settings, sink_hands(node));
  std::optional<SceneShow> scene;
  std::deque<LiveShow> shows;
  const FallFirst fall(node.hands);
  scene.emplace(*systems.front(), settings.decimation, *sink, notices);
  for (std::size_t k = 0; k < node.of_hands.size(); ++k) {
    const HandParts& hand = node.of_hands[k];
    shows.emplace_back(
        ShownHand{k, hand.settings, *systems[k], *hand.device, *hand.view, hand.notices, *hand.recording},
        settings.tf_prefix, *sink);
  }
  bool lacks_memory = false;
  for (int count = 0; network.is_up() && !RunSignals::ended(); ++count) {
    const LoopClock& clock = systems.front()->clock();
    const double begin = clock.now();
    try {
      scene->update();
      publish(shows, scene->scene().get(), *sink, count % LiveShow::kDiagnosticsEvery == 0);
      lacks_memory = false;
    } catch (const std::bad_alloc&) {
      if (!std::exchange(lacks_memory, true)) notices.say("warning: not enough memory to publish");
    }
    clock.sleep_until(begin + 1.0 / LiveShow::kRate);
  }
}

}  // namespace

void run_node(const NodeSettings& settings, const NodeNetwork& network, NodeNotices& notices) {
  std::deque<NodeNotices> of_others;
  std::vector<HandParts> parts;
  std::vector<HandSetup> setups;
  for (const NodeHand& hand : settings.hands) {
    NodeNotices& own = hand.name.empty() ? notices : of_others.emplace_back(notices, hand.name);
    auto device =
        std::make_unique<CrtkDevice>(hand.device.options, network.transport(hand.device.prefix, own));
    parts.push_back({hand, own, device.get()});
    setups.push_back({hand.name, hand.live, std::move(device)});
  }
  std::vector<TickObserver*> devices;
  devices.reserve(setups.size());
  for (const HandSetup& setup : setups) devices.push_back(static_cast<CrtkDevice*>(setup.device.get()));
  LiveHands hands(
      std::move(setups), [&](const std::string& line) { notices.say(line); }, {}, settings.hands_touch);
  NodeScenes scenes(hands, settings.scenes);
  const NodeParts node{hands, scenes, parts};
  if (const auto refused = lock_memory()) notices.say("note: " + *refused);
  std::vector<std::vector<TickObserver*>> observers;
  std::vector<LiveSystem*> systems;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const LiveHands::Hand& hand = hands.all()[k];
    systems.push_back(hand.system.get());
    parts[k].recording = std::make_unique<NodeRecording>(settings.recordings, hand.name, *hand.system);
    observers.push_back({parts[k].view.get(), devices[k], &parts[k].recording->observer()});
  }
  hands.enable();
  const RunSignals signals(systems);  // outlives `end`: a signal during the stop still ramps the force down
  const RecordingsEnd recordings(parts);
  hands.start(observers);
  const LoopEnd end(hands);
  for (const std::string& line : systems.front()->loop().refused()) notices.say("note: " + line);
  serve(settings, network, node, systems, notices);
  hands.stop();
  if (const std::string left = hands.left_devices(); !left.empty()) throw Error("{}", left);
}

}  // namespace palpate::node

#include "run_node.h"

#include <algorithm>
#include <array>
#include <deque>
#include <stdexcept>
#include <string_view>

#include <palpate/base/error.h>
#include <palpate/base/real_time.h>
#include <palpate/live/config_json.h>
#include <palpate/live/config_toml.h>
#include <palpate/live/live_hands.h>
#include <palpate/live/run_signals.h>
#include <palpate/servo/live_view.h>

#include "live_show.h"

namespace palpate::node {
namespace {

/// What there is of each hand besides the live system itself.
struct HandParts {
  const NodeHand& settings;
  NodeNotices& notices;
  const CrtkDevice* device;
  std::unique_ptr<LiveView> view = std::make_unique<LiveView>();
};

/// What may be changed while the node runs: the scene and where it is are as they were at the start.
constexpr std::array<std::string_view, 5> kChangeable{"model", "stiffness", "friction", "detail", "tool"};

/// \throws Refusal for what cannot be.
void change(LiveSystem& system, const std::string& json) {
  const Json wanted = decode_json(json);
  if (!wanted.is_object()) throw Refusal("takes a JSON object, as {\"stiffness\": 800}");
  for (const auto& [name, value] : wanted.items())
    if (std::find(kChangeable.begin(), kChangeable.end(), name) == kChangeable.end())
      throw Refusal("'" + printable(name) +
                    "' cannot be changed here; model, stiffness, friction, detail and tool can");
  system.change([&](LiveConfig& settings) { change_settings(settings, wanted); });
}

/// \param of the first hand: its emergency stop is that of all
NodeServices services_of(LiveHands& hands, const LiveHands::Hand& of, NodeNotices& notices) {
  LiveSystem& system = *of.system;
  NodeServices services;
  services.emergency_stop = [&hands, &system, all = of.name.empty()] {
    all ? hands.stop_force() : system.stop_force();
  };
  services.resume = [&system] { system.resume(); };
  services.pause = [&system](bool on) {
    on ? system.stop_force(Fault::kPaused) : system.tick().governor().unpause();
  };
  services.clutch = [&system](bool on) { system.tick().press_clutch(on); };
  services.get_parameters = [&system] { return encode_json(settings_json(system.settings())); };
  services.config = [&system, first = of.name.empty()] {
    return to_toml(system.settings(), first ? TomlFields::kSaved : TomlFields::kSavedOfHand);
  };
  services.set_parameters = [&system, &notices](const std::string& json) {
    try {
      change(system, json);
    } catch (const std::runtime_error& error) {
      notices.say(std::string("set_parameters: ") + error.what());
    }
  };
  return services;
}

/// Ends the loops before what looks on is gone, whatever happens.
class LoopEnd {
 public:
  explicit LoopEnd(LiveHands& hands) : hands_(hands) {}
  ~LoopEnd() { hands_.stop(); }
  LoopEnd(const LoopEnd&) = delete;
  LoopEnd& operator=(const LoopEnd&) = delete;

 private:
  LiveHands& hands_;
};

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
  std::vector<std::vector<TickObserver*>> observers;
  for (std::size_t k = 0; k < parts.size(); ++k)
    observers.push_back({parts[k].view.get(), static_cast<CrtkDevice*>(setups[k].device.get())});
  LiveHands hands(
      std::move(setups), [&](const std::string& line) { notices.say(line); }, {}, settings.hands_touch);
  if (const auto refused = lock_memory()) notices.say("note: " + *refused);
  hands.start(observers);
  std::vector<LiveSystem*> systems;
  std::vector<SinkHand> of_sink;
  for (const LiveHands::Hand& hand : hands.all()) {
    systems.push_back(hand.system.get());
    of_sink.push_back({hand.name.empty() ? "palpate" : "palpate/" + hand.name,
                       services_of(hands, hand, parts[of_sink.size()].notices)});
  }
  const RunSignals signals(systems);  // which still let the force fall where it falls already
  const LoopEnd end(hands);
  for (const std::string& line : systems.front()->loop().refused()) notices.say("note: " + line);
  const auto sink = network.sink(settings, std::move(of_sink));
  const auto lookup = std::make_shared<const EllipsoidLookup>(*systems.front()->felt()->index());
  publish_centers(*lookup, settings.decimation, *sink);
  std::deque<LiveShow> shows;
  for (std::size_t k = 0; k < parts.size(); ++k)
    shows.emplace_back(
        ShownHand{k, parts[k].settings, *systems[k], *parts[k].device, *parts[k].view, parts[k].notices},
        lookup, settings.tf_prefix, *sink);
  for (int count = 0; network.is_up() && !RunSignals::ended(); ++count) {
    const LoopClock& clock = systems.front()->clock();
    const double begin = clock.now();
    publish(shows, *sink, count % LiveShow::kDiagnosticsEvery == 0);
    clock.sleep_until(begin + 1.0 / LiveShow::kRate);
  }
}

}  // namespace palpate::node

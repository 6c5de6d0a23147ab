#include "run_node.h"

#include <palpate/base/real_time.h>
#include <palpate/live/live_system.h>
#include <palpate/live/run_signals.h>
#include <palpate/servo/live_view.h>

#include "live_show.h"

namespace palpate::node {
namespace {

NodeServices services_of(LiveSystem& system) {
  NodeServices services;
  services.emergency_stop = [&] { system.stop_force(); };
  services.resume = [&] { system.resume(); };
  services.pause = [&](bool on) {
    on ? system.stop_force(Fault::kPaused) : system.tick().governor().unpause();
  };
  services.clutch = [&](bool on) { system.tick().press_clutch(on); };
  return services;
}

/// Ends the loop before what looks on is gone, whatever happens.
class LoopEnd {
 public:
  explicit LoopEnd(LiveSystem& system) : system_(system) {}
  ~LoopEnd() { system_.stop(); }
  LoopEnd(const LoopEnd&) = delete;
  LoopEnd& operator=(const LoopEnd&) = delete;

 private:
  LiveSystem& system_;
};

}  // namespace

void run_node(const NodeSettings& settings, const NodeNetwork& network, NodeNotices& notices) {
  auto own = std::make_unique<CrtkDevice>(settings.device.options,
                                          network.transport(settings.device.prefix, notices));
  const CrtkDevice& device = *own;
  LiveSystem system(settings.live, std::move(own), [&](const std::string& line) { notices.say(line); });
  const auto view = std::make_unique<LiveView>();
  if (const auto refused = lock_memory()) notices.say("note: " + *refused);
  system.start({view.get()});
  const RunSignals signals({&system});  // which still let the force fall where it falls already
  const LoopEnd end(system);
  for (const std::string& line : system.loop().refused()) notices.say("note: " + line);
  const auto sink = network.sink(settings, services_of(system));
  LiveShow show(system, device, *view, notices, settings, *sink);
  show.publish_centers();
  while (network.is_up() && !RunSignals::ended()) {
    const double now = system.clock().now();
    show.publish(now);
    system.clock().sleep_until(now + 1.0 / LiveShow::kRate);
  }
}

}  // namespace palpate::node

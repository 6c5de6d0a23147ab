/// \file
/// Gateway of a live system: what clients see of it, and what they may change.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/live/live_system.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// A file of a page, in memory.
struct WebFile {
  std::string_view path;  ///< on the server
  std::string_view type;  ///< of its content
  std::string_view bytes;
  std::string tag;  ///< of these bytes, for caches
};

/// Pages that a gateway serves besides the system's own. Those that are empty are not served.
struct GatewayPages {
  /// The viewer's file of a path on the server; null if it has none. What it points to lives as long as the
  /// gateway. On the thread of pages.
  std::function<const WebFile*(std::string_view path)> viewer;
  /// The report page of a finished recording, from the path of its file; must not throw. On a thread of its
  /// own.
  std::function<std::string(const std::string& csv)> report;
};

/// Serves a LiveSystem over HTTP and rosbridge: topics, parameters, services, the viewer, the scene's file
/// and recordings; docs/gateway.md describes them. Owner's thread, unless a function says otherwise.
///
///     LiveGateway gateway(system, {});
///     system.start(gateway.observers());
///     gateway.start();
///     ...
///     gateway.stop();
///     system.stop();
class LiveGateway {
 public:
  /// Listens, as the system's GatewayConfig says. `system` must outlive it. \throws Error if the address
  /// cannot be had, or the scene's file not be read.
  LiveGateway(LiveSystem& system, GatewayPages pages);
  ~LiveGateway();
  LiveGateway(const LiveGateway&) = delete;
  LiveGateway& operator=(const LiveGateway&) = delete;

  /// To be given to LiveSystem::start().
  std::vector<TickObserver*> observers();
  /// Once the system has started.
  void start();
  /// Before the system ends.
  void stop();

  /// "http://127.0.0.1:9090/", with the token.
  std::string url() const;
  /// What a person at the terminal should know, since the last call. Any thread.
  std::vector<std::string> take_notices();
  /// A line that the terminal has shown, for those who look at a page. Any thread.
  void say(const std::string& line);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace palpate

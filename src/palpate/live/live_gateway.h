/// \file
/// Gateway of live hands: what clients see of them, and what they may change.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/live/live_hands.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// A file of a page, in memory.
struct WebFile {
  std::string_view path;  ///< on the server
  std::string_view type;  ///< of its content
  std::string_view bytes;
  std::string tag;  ///< of these bytes, for caches
};

/// What a gateway serves besides the system's own, and what pages may open. Pages that are empty are not
/// served.
struct GatewayPages {
  /// The viewer's file of a path on the server; null if it has none. What it points to lives as long as the
  /// gateway. On the thread of pages.
  std::function<const WebFile*(std::string_view path)> viewer;
  /// The report page of a finished recording, from the path of its file; must not throw. On a thread of its
  /// own.
  std::function<std::string(const std::string& csv)> report;
  /// Folders whose scenes a page may open; see SceneLibrary.
  std::vector<std::string> scene_folders = {};
  /// Why no other scene may be opened; empty where one may.
  std::string one_scene = {};
};

/// Serves the hands of a LiveHands over HTTP and rosbridge: topics, parameters, services, the viewer, the
/// scene's file and recordings; docs/gateway.md describes them. Owner's thread, unless a function says
/// otherwise.
///
///     LiveGateway gateway(hands, {});
///     hands.start({gateway.observers(0), gateway.observers(1)});
///     gateway.start();
///     ...
///     gateway.stop();
///     hands.stop();
class LiveGateway {
 public:
  /// Listens, as the first hand's GatewayConfig says. `hands` must outlive it. \throws Error if the address
  /// cannot be had, or the scene's file not be read.
  LiveGateway(LiveHands& hands, GatewayPages pages);
  ~LiveGateway();
  LiveGateway(const LiveGateway&) = delete;
  LiveGateway& operator=(const LiveGateway&) = delete;

  /// To be given to LiveHands::start(), of each hand.
  std::vector<TickObserver*> observers(std::size_t hand);
  /// Once the hands have started.
  void start();
  /// Before the hands end.
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

/// \file
/// HTTP and rosbridge gateway of a live system.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/live/live_hands.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

/// In-memory file of a web page.
struct WebFile {
  std::string_view path;  ///< URL path on the server
  std::string_view type;  ///< MIME type
  std::string_view bytes;
  std::string tag;  ///< entity tag of `bytes`, for caches
};

/// Additional pages that a gateway serves, and the scenes that its clients may open. Empty functions are not
/// served.
struct GatewayPages {
  /// Returns the viewer's file at a URL path; null if there is none. The file lives as long as the gateway.
  /// Called on the page thread.
  std::function<const WebFile*(std::string_view path)> viewer;
  /// Returns the report page of a finished recording, given the path of its file; must not throw. Called on a
  /// thread of its own.
  std::function<std::string(const std::string& csv)> report;
  /// Folders whose scenes a client may open; see SceneLibrary.
  std::vector<std::string> scene_folders = {};
  /// Reason why no other scene may be opened, nor the scene be placed otherwise; empty if they may.
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
  /// Starts listening, with the GatewayConfig of the first hand. `hands` must outlive it. \throws Error if
  /// the address cannot be bound or the scene's file cannot be read.
  LiveGateway(LiveHands& hands, GatewayPages pages);
  ~LiveGateway();
  LiveGateway(const LiveGateway&) = delete;
  LiveGateway& operator=(const LiveGateway&) = delete;

  /// Returns the tick observers of a hand, to be passed to LiveHands::start().
  std::vector<TickObserver*> observers(std::size_t hand);
  /// Starts serving. Called after the hands have started.
  void start();
  /// Stops serving. Called before the hands stop.
  void stop();

  /// Returns the URL, e.g. "http://127.0.0.1:9090/", including the token.
  std::string url() const;
  /// Returns the notices for the terminal since the last call. Any thread.
  std::vector<std::string> take_notices();
  /// Shows a line of the terminal to the web clients. Any thread.
  void say(const std::string& line);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace palpate

/// \file
/// One port for pages, files and rosbridge.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/base/real_time.h>
#include <palpate/rosbridge/hub.h>
#include <palpate/rosbridge/wake.h>

namespace palpate {

/// What a path of the server has.
struct WebPage {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string_view bytes;             ///< good while `keeps` lives
  std::shared_ptr<const void> keeps;  ///< what owns them; null: they live as long as the program
  std::string tag;                    ///< of this version of it, for caches; empty: not to be kept
  std::string policy;                 ///< Content-Security-Policy; empty: nothing may be loaded
};
WebPage text_page(int status, std::string text);

struct WebServerOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 9090;  ///< 0: any that is free
  std::string token;          ///< that every request must bring; empty: none
  /// Of the server's thread, which hands over the hands of clients, where that is permitted; unset: ordinary.
  std::optional<ThreadPriority> real_time;
};

/// Serves HTTP/1.1 (GET and HEAD, ranges, validation) and, for requests to upgrade, rosbridge v2 over
/// WebSocket, on a thread of its own, which the Hub belongs to from start() to stop(). What a client sends
/// that is long is decoded on another, so that it keeps nobody's pose waiting.
///
/// Refused are requests whose Host is not an address of this server (DNS rebinding), those of pages of
/// another Origin, and those without the token.
class WebServer {
 public:
  /// Gets the path, decoded, without the query. Called on the server's thread.
  using Site = std::function<WebPage(const std::string& path)>;

  /// Listens. `hub` must outlive it. \throws Error if the address cannot be had.
  WebServer(Hub& hub, Site site, const WebServerOptions& options);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// \name Before start()
  /// @{
  /// Calls `work` `rate` times a second, on the server's thread. Unit: [Hz].
  void every(double rate, std::function<void()> work);
  /// Calls `work` there when `wake` is set; `work` clears it.
  void when(Wake& wake, std::function<void()> work);
  /// @}

  void start();
  /// Closes all connections and ends the thread.
  void stop();

  /// Runs `work` on the server's thread. Any thread.
  void post(std::function<void()> work);

  std::uint16_t port() const;
  /// "http://127.0.0.1:9090/", with the token; by this machine's name where all of its addresses are listened
  /// on.
  std::string url() const;

  static constexpr std::size_t kMostClients = 128;        ///< WebSockets
  static constexpr std::size_t kMostConnections = 256;    ///< of both kinds
  static constexpr std::size_t kMostMessage = 256 << 10;  ///< bytes of a message

 private:
  class Implementation;
  std::shared_ptr<Implementation> implementation_;
};

}  // namespace palpate

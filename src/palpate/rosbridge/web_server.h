/// \file
/// Web server for pages, files and rosbridge on one port.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/base/file.h>
#include <palpate/base/real_time.h>
#include <palpate/rosbridge/elsewhere.h>
#include <palpate/rosbridge/hub.h>
#include <palpate/rosbridge/wake.h>

namespace palpate {

/// Response to a request for a path.
struct WebPage {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string_view bytes;             ///< valid while `keeps` lives
  std::shared_ptr<const void> keeps;  ///< owner of `bytes`; null: static lifetime
  std::string tag;                    ///< entity tag of this version, for caches; empty: not cacheable
  std::string policy;                 ///< Content-Security-Policy; empty: nothing may be loaded
  /// Sent in place of `bytes`: read while being sent, so that it need not fit into memory. Sent with its
  /// length at opening; if it is truncated meanwhile, the connection ends.
  std::shared_ptr<const InputFile> file;
  std::string location;  ///< redirect target; empty: none
  int retry_after = 0;   ///< time after which a client may ask again; 0: not stated. Unit: [s].
};
WebPage text_page(int status, std::string text);

/// Handlers of uploaded files (PUT). Called on the page thread; may throw Error, which is reported to the
/// client.
struct WebUploads {
  std::string folder;  ///< URL folder such as "/folder/"; uploads are accepted only there
  /// Returns the path on the disk for an upload to URL path `path`, of `bytes` bytes.
  std::function<std::string(const std::string& path, std::uint64_t bytes)> place;
  /// Called when the upload is complete. Returns the response.
  std::function<WebPage(const std::string& file)> have;
  /// Called when the upload was aborted.
  std::function<void(const std::string& file)> drop;
};

struct WebServerOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 9090;  ///< 0: any that is free
  std::string token;          ///< required of every request; empty: none
  /// Real-time priority of the server thread, which passes on the poses of clients, if permitted; unset:
  /// normal.
  std::optional<ThreadPriority> real_time;
  WebUploads uploads;  ///< without `place` uploads are refused
  /// Called on the page thread with a printable line for the person at the terminal
  /// (Access::Refused::notice); empty: not called.
  std::function<void(const std::string& line)> tell = {};
  /// Files for TlsRelay: all connections then use TLS. Both empty: no TLS.
  std::string tls_certificate = {}, tls_key = {};
};

/// Serves HTTP/1.1 (GET and HEAD, ranges, validation; PUT of one file at a time) and, on upgrade requests,
/// rosbridge v2 over WebSocket. Runs these threads from start() to stop():
///
/// - the server thread, real-time if permitted, with the WebSockets, the timers and the Hub;
/// - the page thread, with all other connections, so that disk reads do not delay poses;
/// - one that decodes long messages of clients, for the same reason;
/// - one for slow work, elsewhere();
/// - with TLS, the thread of TlsRelay.
///
/// Refuses requests whose Host is not an address of this server (DNS rebinding), requests from pages of
/// another Origin, and requests without the token. A connection without an accepted request is a stranger:
/// there are at most kMostStrangers, each for at most kStrangerTime, and the oldest is dropped for a new one,
/// so that strangers cannot block other clients.
class WebServer {
 public:
  /// Returns the page of a path, given decoded and without the query. Called on the page thread.
  using Site = std::function<WebPage(const std::string& path)>;

  /// Starts listening. `hub` must outlive it. \throws Error if the address cannot be bound, or as TlsRelay
  /// does.
  WebServer(Hub& hub, Site site, const WebServerOptions& options);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// \name Before start()
  /// @{
  /// Calls `work` `rate` times a second, on the server's thread. Unit: [Hz].
  void every(double rate, std::function<void()> work);
  /// Calls `work` on that thread when `wake` is set; `work` clears it.
  void when(Wake& wake, std::function<void()> work);
  /// @}

  void start();
  /// Closes all connections and ends the threads.
  void stop();

  /// Runs `work` on the server's thread. Any thread.
  void post(std::function<void()> work);
  /// Implements Elsewhere for the server's thread. Any thread.
  void elsewhere(std::function<void()> work, std::function<void()> then);

  std::uint16_t port() const;
  /// Returns the URL, e.g. "http://127.0.0.1:9090/", or https, including the token; uses the host name if the
  /// server listens on all addresses.
  std::string url() const;

  static constexpr std::size_t kMostClients = 128;        ///< WebSockets
  static constexpr std::size_t kMostConnections = 128;    ///< other connections with an accepted request
  static constexpr std::size_t kMostStrangers = 16;       ///< connections without one
  static constexpr double kStrangerTime = 5.0;            ///< Unit: [s].
  static constexpr std::size_t kMostMessage = 256 << 10;  ///< bytes of a message
  static constexpr std::uint64_t kMostUpload = std::uint64_t{16} << 30;  ///< bytes of a file

 private:
  class Implementation;
  std::shared_ptr<Implementation> implementation_;
};

}  // namespace palpate

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

#include <palpate/base/file.h>
#include <palpate/base/real_time.h>
#include <palpate/rosbridge/elsewhere.h>
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
  /// In place of `bytes`: read as it is sent, so that it need not fit into memory and may be cut meanwhile,
  /// which ends the connection. As long as it was when it was opened.
  std::shared_ptr<const InputFile> file;
  std::string location;  ///< to ask for instead; empty: none
};
WebPage text_page(int status, std::string text);

/// What becomes of files that clients hand over (PUT). Called on the thread of pages; may throw Error, which
/// the client is told.
struct WebUploads {
  std::string folder;  ///< of the server, as "/folder/": files are taken there alone
  /// The place on the disk for the file at `path` of the server, of `bytes` bytes.
  std::function<std::string(const std::string& path, std::uint64_t bytes)> place;
  /// It is whole. Returns the answer.
  std::function<WebPage(const std::string& file)> have;
  /// It is not, and does not come any more.
  std::function<void(const std::string& file)> drop;
};

struct WebServerOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 9090;  ///< 0: any that is free
  std::string token;          ///< that every request must bring; empty: none
  /// Of the server's thread, which hands over the hands of clients, where that is permitted; unset: ordinary.
  std::optional<ThreadPriority> real_time;
  WebUploads uploads;  ///< without `place` none are taken
  /// Files of TlsRelay: all connections are over TLS then. Both empty: none is.
  std::string tls_certificate = {}, tls_key = {};
};

/// Serves HTTP/1.1 (GET and HEAD, ranges, validation; PUT of one file at a time) and, for requests to
/// upgrade, rosbridge v2 over WebSocket. It has these threads from start() to stop():
///
/// - the server's own, of real time where that is permitted, with the WebSockets, the timers and the Hub;
/// - that of pages, with all other connections: what is read from a disk keeps no pose waiting;
/// - one that decodes what clients send that is long, for the same reason;
/// - one for slow work, elsewhere();
/// - with TLS, that of TlsRelay.
///
/// Refused are requests whose Host is not an address of this server (DNS rebinding), those of pages of
/// another Origin, and those without the token. A connection that has not had a request which is not refused
/// is a stranger: there are kMostStrangers of them at most, for kStrangerTime at most, and the oldest makes
/// room for the next, so that none of them is in the way of anybody else.
class WebServer {
 public:
  /// Gets the path, decoded, without the query. Called on the thread of pages.
  using Site = std::function<WebPage(const std::string& path)>;

  /// Listens. `hub` must outlive it. \throws Error if the address cannot be had, or as TlsRelay does.
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
  /// Closes all connections and ends the threads.
  void stop();

  /// Runs `work` on the server's thread. Any thread.
  void post(std::function<void()> work);
  /// Elsewhere, of the server's thread. Any thread.
  void elsewhere(std::function<void()> work, std::function<void()> then);

  std::uint16_t port() const;
  /// "http://127.0.0.1:9090/", or https, with the token; by this machine's name where all of its addresses
  /// are listened on.
  std::string url() const;

  static constexpr std::size_t kMostClients = 128;        ///< WebSockets
  static constexpr std::size_t kMostConnections = 128;    ///< others that have asked for something
  static constexpr std::size_t kMostStrangers = 16;       ///< that have not, or may not
  static constexpr double kStrangerTime = 5.0;            ///< Unit: [s].
  static constexpr std::size_t kMostMessage = 256 << 10;  ///< bytes of a message
  static constexpr std::uint64_t kMostUpload = std::uint64_t{16} << 30;  ///< bytes of a file

 private:
  class Implementation;
  std::shared_ptr<Implementation> implementation_;
};

}  // namespace palpate

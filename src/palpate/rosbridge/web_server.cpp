// GCC 12 needs <utility> before Asio. All of Beast is in this one source: it takes the compiler half a
// minute.
#include <utility>

#include <palpate/rosbridge/web_server.h>

#include <chrono>
#include <deque>
#include <list>
#include <optional>
#include <set>
#include <thread>

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <fmt/format.h>
#include <boost/asio/dispatch.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include <palpate/base/clock.h>
#include <palpate/base/error.h>
#include <palpate/base/real_time.h>
#include <palpate/rosbridge/access.h>

namespace palpate {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = net::ip::tcp;
using boost::system::error_code;
using Request = http::request<http::string_body>;

constexpr auto kHttpTimeout = std::chrono::seconds(30);
constexpr std::size_t kMostHeader = 16 << 10, kMostBody = 4 << 10;
/// A peer that does not answer a ping for so long is gone.
constexpr auto kIdle = std::chrono::seconds(30);

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

RequestHead head_of(const Request& request) {
  return {view(request[http::field::host]), view(request[http::field::origin]),
          view(request[http::field::authorization]), view(request[http::field::cookie]),
          view(request.target())};
}

/// What all sessions share. On the server's thread.
struct Shared {
  Hub& hub;
  WebServer::Site site;
  Access access;
  /// Has `work` done on the server's other thread, and then `then` on its own. Keeps neither from its end.
  std::function<void(std::function<void()> work, std::function<void()> then)> elsewhere;
  std::size_t connections = 0, sockets = 0;
  /// To close whatever is open.
  std::set<class Session*> sessions;
  /// With a frame that waits, in the order in which they came.
  std::deque<std::shared_ptr<class SocketSession>> turn;
};

/// A frame that is longer is decoded on the other thread: what this takes is a fraction of a millisecond.
constexpr std::size_t kShort = 4 << 10;
/// How long frames of those who hold no hand may take between two looks at the sockets. Unit: [s].
constexpr double kTurnTime = 3e-4;

/// Something that is open.
class Session {
 public:
  explicit Session(Shared& shared) : shared_(shared) { shared_.sessions.insert(this); }
  virtual ~Session() { shared_.sessions.erase(this); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  virtual void close() = 0;

 protected:
  Shared& shared_;
};

/// One WebSocket and its Client.
class SocketSession final : public Session, public std::enable_shared_from_this<SocketSession> {
 public:
  SocketSession(Shared& shared, tcp::socket&& socket)
      : Session(shared),
        socket_(std::move(socket)),
        client_(
            shared.hub, [this] { wake(); }, monotonic_now) {
    ++shared_.sockets;
  }
  ~SocketSession() override { --shared_.sockets; }

  void accept(const Request& request) {
    websocket::stream_base::timeout timeout{};
    timeout.handshake_timeout = kHttpTimeout;
    timeout.idle_timeout = kIdle;
    timeout.keep_alive_pings = true;
    socket_.set_option(timeout);
    socket_.read_message_max(WebServer::kMostMessage);
    socket_.auto_fragment(false);
    socket_.async_accept(request, [self = shared_from_this()](error_code error) {
      if (error) return;
      self->open_ = true;
      self->read();
      self->write();
    });
  }

  void close() override { beast::get_lowest_layer(socket_).close(); }

  /// Takes the frame that was read, and reads on.
  void take_frame() { take(Client::decode(frame(), socket_.got_binary())); }

 private:
  std::string_view frame() const {
    const auto bytes = buffer_.cdata();
    return {static_cast<const char*>(bytes.data()), bytes.size()};
  }

  /// Nothing more is read before this frame is taken: what a client sends faster waits at its end.
  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      ++self->frames_;
      if (error) return self->close();
      if (!self->client_.admit(self->buffer_.size())) return self->say_goodbye();
      if (self->buffer_.size() > kShort) return self->decode_elsewhere();
      if (self->client_.is_urgent()) return self->take_frame();
      self->wait_for_turn();
    });
  }

  /// One at a time of each client; the message ends there, too, since that takes as long.
  void decode_elsewhere() {
    const auto decoded = std::make_shared<Client::Decoded>();
    shared_.elsewhere([self = shared_from_this(), decoded,
                       binary = socket_.got_binary()] { *decoded = Client::decode(self->frame(), binary); },
                      [self = shared_from_this(), decoded] {
                        self->take(*decoded);
                        self->shared_.elsewhere([decoded] { *decoded = {}; }, [] {});
                      });
  }

  void wait_for_turn() {
    shared_.turn.push_back(shared_from_this());
    if (shared_.turn.size() == 1)
      net::post(socket_.get_executor(), [self = shared_from_this()] { self->take_turns(); });
  }

  /// As many frames as there is time for; those of whom is urgent come in between.
  void take_turns() {
    const double until = monotonic_now() + kTurnTime;
    std::shared_ptr<SocketSession> last;
    do {
      last = shared_.turn.front();
      last->take_frame();
      shared_.turn.pop_front();  // only now: what comes meanwhile finds that turns are being taken
    } while (!shared_.turn.empty() && monotonic_now() < until);
    if (!shared_.turn.empty())
      net::post(socket_.get_executor(), [self = shared_.turn.front()] { self->take_turns(); });
  }

  void take(const Client::Decoded& decoded) {
    client_.take(decoded);
    buffer_.consume(buffer_.size());
    if (!client_.fault().empty()) return say_goodbye();
    read();
    // Where another frame is here already, that was posted before this, and counts.
    net::post(socket_.get_executor(), [self = shared_from_this(), seen = frames_] {
      if (seen == self->frames_) self->client_.caught_up();
    });
  }

  /// The client has something to send: once whoever gave it that is done.
  void wake() {
    if (woken_) return;
    woken_ = true;
    net::post(socket_.get_executor(), [weak = weak_from_this()] {
      if (const auto self = weak.lock()) {
        self->woken_ = false;
        self->write();
      }
    });
  }

  void write() {
    if (!open_ || writing_) return;
    if (!client_.fault().empty()) return say_goodbye();
    const auto outgoing = client_.next();
    if (!outgoing) return hold_back(false);
    if (client_.has_next()) hold_back(true);
    writing_ = true;
    sent_ = outgoing->bytes;
    socket_.binary(outgoing->binary);
    socket_.async_write(net::buffer(*sent_), [self = shared_from_this()](error_code error, std::size_t) {
      self->writing_ = false;
      if (error) return self->close();
      self->write();
    });
    // What fits is with the kernel by now.
    if (!client_.has_next()) hold_back(false);
  }

  /// While there is more to send, what has been is held back: all that waits goes out as one packet and wakes
  /// its reader once. With many clients on one machine that is time that the servo loop's processors have.
  void hold_back(bool on) {
    if (held_back_ == on) return;
    held_back_ = on;
    const int value = on ? 1 : 0;
    ::setsockopt(beast::get_lowest_layer(socket_).socket().native_handle(), IPPROTO_TCP, TCP_CORK, &value,
                 sizeof value);
  }

  /// Closes with the reason, if the client still reads that.
  void say_goodbye() {
    if (!open_) return;
    open_ = false;
    hold_back(false);
    if (writing_) return close();  // it does not even take what is under way
    const websocket::close_reason reason(websocket::close_code::policy_error, client_.fault());
    socket_.async_close(reason, [self = shared_from_this()](error_code) { self->close(); });
  }

  /// Without compression: messages are small and must be quick.
  websocket::stream<beast::tcp_stream, false> socket_;
  beast::flat_buffer buffer_;
  Client client_;
  std::shared_ptr<const std::string> sent_;
  std::uint64_t frames_ = 0;  ///< that were read
  bool open_ = false, writing_ = false, woken_ = false, held_back_ = false;
};

/// One connection of HTTP, which may become a WebSocket.
class HttpSession final : public Session, public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(Shared& shared, tcp::socket&& socket) : Session(shared), stream_(std::move(socket)) {
    ++shared_.connections;
  }
  ~HttpSession() override { --shared_.connections; }

  void read() {
    parser_.emplace();
    parser_->header_limit(kMostHeader);
    parser_->body_limit(kMostBody);
    stream_.expires_after(kHttpTimeout);
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return self->close();
      self->handle(self->parser_->release());
    });
  }

  void close() override { stream_.close(); }

 private:
  void handle(const Request& request) {
    if (const auto refused = shared_.access.refusal(head_of(request)))
      return send(request, text_page(refused->status, refused->why));
    if (websocket::is_upgrade(request)) {
      if (shared_.sockets == WebServer::kMostClients)
        return send(request, text_page(503, "too many clients are connected"));
      stream_.expires_never();
      std::make_shared<SocketSession>(shared_, stream_.release_socket())->accept(request);
      return;
    }
    if (request.method() != http::verb::get && request.method() != http::verb::head)
      return send(request, text_page(405, "only GET and HEAD are answered here"));
    const auto path = path_of(view(request.target()));
    send(request, path ? shared_.site(*path) : text_page(400, "this is no path"));
  }

  void send(const Request& request, WebPage page) {
    page_ = std::move(page);
    answer_ = {};
    answer_.version(request.version());
    answer_.keep_alive(request.keep_alive());
    answer_.set(http::field::server, "palpate");
    answer_.set(http::field::content_type, page_.type);
    answer_.set("X-Content-Type-Options", "nosniff");
    answer_.set("X-Frame-Options", "DENY");
    answer_.set("Referrer-Policy", "no-referrer");
    answer_.set("Cross-Origin-Opener-Policy", "same-origin");
    answer_.set("Cross-Origin-Resource-Policy", "same-origin");
    answer_.set("Content-Security-Policy", page_.policy.empty() ? "default-src 'none'" : page_.policy);
    if (page_.status == 401) answer_.set(http::field::www_authenticate, "Bearer");
    if (page_.status == 405) answer_.set(http::field::allow, "GET, HEAD");
    remember_token(request);
    std::string_view body = page_.bytes;
    if (!page_.tag.empty()) {
      const std::string tag = '"' + page_.tag + '"';
      answer_.set(http::field::etag, tag);
      answer_.set(http::field::cache_control, "no-cache");  // kept, and asked for again
      answer_.set(http::field::accept_ranges, "bytes");
      body = part(request, tag);
    } else {
      answer_.set(http::field::cache_control, "no-store");
      answer_.result(static_cast<unsigned>(page_.status));
    }
    answer_.body() = {body.data(), body.size()};
    answer_.prepare_payload();
    if (answer_.result() == http::status::not_modified) answer_.erase(http::field::content_length);
    stream_.expires_after(kHttpTimeout);
    serializer_.emplace(answer_);
    head_only_ = request.method() == http::verb::head;
    serializer_->split(head_only_);  // the head is a piece of its own
    write_some();
  }

  /// In pieces, so that only a peer that takes nothing at all runs out of time, and not one that is slow.
  void write_some() {
    constexpr std::size_t kPiece = 1 << 18;
    serializer_->limit(kPiece);
    http::async_write_some(stream_, *serializer_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return self->close();
      self->stream_.expires_after(kHttpTimeout);
      const bool all = self->head_only_ ? self->serializer_->is_header_done() : self->serializer_->is_done();
      all ? self->done() : self->write_some();
    });
  }

  void done() {
    const bool goes_on = answer_.keep_alive();
    serializer_.reset();
    page_ = {};
    goes_on ? read() : close();
  }

  /// What the request wants of the page, and the status for that.
  std::string_view part(const Request& request, const std::string& tag) {
    const std::string_view known = view(request[http::field::if_none_match]);
    if (known == "*" || known.find(tag) != std::string_view::npos) {
      answer_.result(http::status::not_modified);
      return {};
    }
    const std::string_view condition = view(request[http::field::if_range]);
    const bool whole = (!condition.empty() && condition != tag) || request.method() == http::verb::head;
    const RangeRequest asked =
        whole ? RangeRequest{} : parse_range(view(request[http::field::range]), page_.bytes.size());
    answer_.result(static_cast<unsigned>(page_.status));
    if (asked.kind == RangeRequest::Kind::kNone) return page_.bytes;
    if (asked.kind == RangeRequest::Kind::kUnsatisfiable) {
      answer_.result(http::status::range_not_satisfiable);
      answer_.set(http::field::content_range, fmt::format("bytes */{}", page_.bytes.size()));
      return {};
    }
    const auto [first, count] = asked.range;
    answer_.result(http::status::partial_content);
    answer_.set(http::field::content_range,
                fmt::format("bytes {}-{}/{}", first, first + count - 1, page_.bytes.size()));
    return page_.bytes.substr(first, count);
  }

  /// Whoever came with the token need not bring it again: a page cannot add it to all that it loads.
  void remember_token(const Request& request) {
    const std::string& token = shared_.access.token();
    if (token.empty() || query_value(view(request.target()), "token") != token) return;
    answer_.set(http::field::set_cookie, fmt::format("palpate={}; Path=/; HttpOnly; SameSite=Strict", token));
  }

  using Answer = http::response<http::span_body<const char>>;

  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  WebPage page_;
  Answer answer_;
  std::optional<http::response_serializer<http::span_body<const char>>> serializer_;
  bool head_only_ = false;
};

}  // namespace

WebPage text_page(int status, std::string text) {
  auto kept = std::make_shared<const std::string>(std::move(text) + '\n');
  WebPage page;
  page.status = status;
  page.bytes = *kept;
  page.keeps = std::move(kept);
  return page;
}

class WebServer::Implementation : public std::enable_shared_from_this<Implementation> {
 public:
  Implementation(Hub& hub, Site site, const WebServerOptions& options)
      : real_time_(options.real_time), acceptor_(context_), address_(options.address), retry_(context_) {
    error_code error;
    const auto address = net::ip::make_address(options.address, error);
    if (error) throw Error("{}: is not an address to listen on; give one of this machine", options.address);
    const tcp::endpoint endpoint(address, options.port);
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(net::socket_base::max_listen_connections, error);
    if (error) {
      throw Error("cannot listen on {} port {}: {}; give another --port, or --no-gateway", options.address,
                  options.port, error.message());
    }
    port_ = acceptor_.local_endpoint().port();
    shared_.emplace(Shared{hub,
                           std::move(site),
                           Access(options.address, port_, options.token),
                           [this](auto work, auto then) { elsewhere(std::move(work), std::move(then)); },
                           0,
                           0,
                           {},
                           {}});
  }

  void every(double rate, std::function<void()> work) {
    timers_.push_back({net::steady_timer(context_), std::chrono::nanoseconds(static_cast<long>(1e9 / rate)),
                       std::move(work)});
  }

  void when(Wake& wake, std::function<void()> work) {
    watches_.push_back({net::posix::stream_descriptor(context_, wake.descriptor()), std::move(work)});
  }

  void start() {
    accept();
    for (Timer& timer : timers_) {
      timer.timer.expires_after(timer.period);
      wait(timer);
    }
    for (Watch& watch : watches_) wait(watch);
    thread_ = std::thread([this] {
      name_thread("palpate-gateway");
      if (real_time_) make_real_time(*real_time_);  // the loop has told why not, if not
      context_.run();
    });
    other_thread_ = std::thread([this] {
      name_thread("palpate-pages");
      other_.run();
    });
  }

  void stop() {
    if (thread_.joinable()) {
      net::post(context_, [this] {
        error_code ignored;
        acceptor_.close(ignored);
        retry_.cancel();
        for (Timer& timer : timers_) timer.timer.cancel();
        for (Watch& watch : watches_) watch.descriptor.cancel(ignored);
        ends_ = true;
        const std::set<Session*> open = shared_->sessions;
        for (Session* session : open) session->close();
      });
      thread_.join();
      other_.stop();
      other_thread_.join();
      shared_->turn.clear();
    }
    for (Watch& watch : watches_) watch.descriptor.release();  // its owner closes it
    watches_.clear();
  }

  void post(std::function<void()> work) { net::post(context_, std::move(work)); }
  void elsewhere(std::function<void()> work, std::function<void()> then) {
    net::post(other_, [this, work = std::move(work), then = std::move(then)]() mutable {
      work();
      work = nullptr;
      net::post(context_, std::move(then));
    });
  }
  std::uint16_t port() const { return port_; }
  const std::string& address() const { return address_; }
  const std::string& token() const { return shared_->access.token(); }

 private:
  struct Timer {
    net::steady_timer timer;
    std::chrono::nanoseconds period;
    std::function<void()> work;
  };
  struct Watch {
    net::posix::stream_descriptor descriptor;
    std::function<void()> work;
  };

  void accept() {
    acceptor_.async_accept([this](error_code error, tcp::socket socket) {
      if (ends_ || error == net::error::operation_aborted) return;
      if (error) {  // no more descriptors, say: later there may be
        retry_.expires_after(std::chrono::milliseconds(100));
        retry_.async_wait([this](error_code cancelled) {
          if (!cancelled) accept();
        });
        return;
      }
      if (shared_->connections + shared_->sockets < WebServer::kMostConnections) {
        error_code ignored;
        socket.set_option(tcp::no_delay(true), ignored);
        std::make_shared<HttpSession>(*shared_, std::move(socket))->read();
      }  // else it is closed here
      accept();
    });
  }

  void wait(Timer& timer) {
    timer.timer.async_wait([this, &timer](error_code error) {
      if (error || ends_) return;
      timer.work();
      // From when it was due, so that the rate is kept; what was missed is not made up for.
      const auto next = timer.timer.expiry() + timer.period;
      timer.timer.expires_at(std::max(next, std::chrono::steady_clock::now()));
      wait(timer);
    });
  }

  void wait(Watch& watch) {
    watch.descriptor.async_wait(net::posix::stream_descriptor::wait_read, [this, &watch](error_code error) {
      if (error || ends_) return;
      watch.work();
      wait(watch);
    });
  }

  std::optional<Shared> shared_;  ///< outlives what is still to be called in the contexts
  net::io_context context_{1};
  net::io_context other_{1};
  net::executor_work_guard<net::io_context::executor_type> other_stays_ = net::make_work_guard(other_);
  std::optional<ThreadPriority> real_time_;
  tcp::acceptor acceptor_;
  std::string address_;
  std::uint16_t port_ = 0;
  net::steady_timer retry_;
  std::list<Timer> timers_;
  std::list<Watch> watches_;
  bool ends_ = false;
  std::thread thread_, other_thread_;
};

WebServer::WebServer(Hub& hub, Site site, const WebServerOptions& options)
    : implementation_(std::make_shared<Implementation>(hub, std::move(site), options)) {}
WebServer::~WebServer() { stop(); }
void WebServer::every(double rate, std::function<void()> work) {
  implementation_->every(rate, std::move(work));
}
void WebServer::when(Wake& wake, std::function<void()> work) { implementation_->when(wake, std::move(work)); }
void WebServer::start() { implementation_->start(); }
void WebServer::stop() { implementation_->stop(); }
void WebServer::post(std::function<void()> work) { implementation_->post(std::move(work)); }
std::uint16_t WebServer::port() const { return implementation_->port(); }

std::string WebServer::url() const {
  std::string address = implementation_->address();
  if (address == "0.0.0.0" || address == "::") address = net::ip::host_name();
  const bool six = address.find(':') != std::string::npos;
  const std::string& token = implementation_->token();
  return fmt::format("http://{}:{}/{}", six ? '[' + address + ']' : address, port(),
                     token.empty() ? "" : "?token=" + token);
}

}  // namespace palpate

// GCC 12 needs <utility> before Asio. All uses of Beast are in this source, since it takes half a minute to
// compile.
#include <utility>

#include <palpate/rosbridge/web_server.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <list>
#include <new>
#include <optional>
#include <set>
#include <stdexcept>
#include <vector>

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <fmt/format.h>
#include <boost/asio/dispatch.hpp>
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
#include <palpate/rosbridge/lane.h>
#include <palpate/rosbridge/own_address.h>
#include <palpate/rosbridge/tls_relay.h>

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
/// Time for which data of a refused upload is read and discarded.
constexpr auto kDrain = std::chrono::seconds(5);
/// Time without an answer to a ping after which a peer is disconnected.
constexpr auto kIdle = std::chrono::seconds(30);

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

template <class Body>
RequestHead head_of(const http::request<Body>& request) {
  RequestHead head;
  head.host = view(request[http::field::host]);
  head.origin = view(request[http::field::origin]);
  head.authorization = view(request[http::field::authorization]);
  head.cookie = view(request[http::field::cookie]);
  head.target = view(request.target());
  return head;
}

/// Returns the address of a peer, for GuessLimit.
std::string address_of(const tcp::socket& socket) {
  error_code ignored;
  return guesser_at(socket.remote_endpoint(ignored).address().to_string());
}

/// Occupies one of a limited number of places during its lifetime.
class Place {
 public:
  explicit Place(std::atomic<std::size_t>& taken) : taken_(taken) { ++taken_; }
  ~Place() { --taken_; }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;

 private:
  std::atomic<std::size_t>& taken_;
};

/// State shared by all WebSockets. Used on the server's thread.
struct Shared {
  Hub& hub;
  /// Runs `work` on the decoder thread, and then `then` on the server's. Neither thread waits for it when it
  /// ends.
  Elsewhere decode;
  /// Open sessions, to close them at the end.
  std::set<class SocketSession*> sessions;
  /// Sessions with a frame to be processed, in order of arrival.
  std::deque<std::shared_ptr<class SocketSession>> turn;
  bool turns_are_posted = false;  ///< take_turns() will run
};

/// Longest frame that is decoded on the server's thread, in a fraction of a millisecond. Unit: [bytes].
constexpr std::size_t kShort = 4 << 10;
/// Time spent on frames of clients without a hand before the sockets are polled again. Unit: [s].
constexpr double kTurnTime = 3e-4;

/// A WebSocket and its Client.
class SocketSession final : public std::enable_shared_from_this<SocketSession> {
 public:
  SocketSession(Shared& shared, tcp::socket&& socket, std::unique_ptr<Place> place)
      : shared_(shared),
        place_(std::move(place)),
        socket_(std::move(socket)),
        client_(
            shared.hub, [this] { wake(); }, monotonic_now) {
    shared_.sessions.insert(this);
  }
  ~SocketSession() { shared_.sessions.erase(this); }
  SocketSession(const SocketSession&) = delete;
  SocketSession& operator=(const SocketSession&) = delete;

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

  void close() { beast::get_lowest_layer(socket_).close(); }

  /// Processes the frame that was read, and reads the next.
  void take_frame() { take(Client::decode(frame(), socket_.got_binary())); }

 private:
  std::string_view frame() const {
    const auto bytes = buffer_.cdata();
    return {static_cast<const char*>(bytes.data()), bytes.size()};
  }

  /// Reads the next frame. No other is read until it is processed: a client that sends faster must wait.
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

  /// Decodes one frame per client at a time. The message is also destroyed there, which takes as long.
  void decode_elsewhere() {
    const auto decoded = std::make_shared<Client::Decoded>();
    shared_.decode([self = shared_from_this(), decoded,
                    binary = socket_.got_binary()] { *decoded = Client::decode(self->frame(), binary); },
                   [self = shared_from_this(), decoded] {
                     self->take(*decoded);
                     self->shared_.decode([decoded] { *decoded = {}; }, [] {});
                   });
  }

  void wait_for_turn() {
    shared_.turn.push_back(shared_from_this());
    if (!take_turns_soon()) take_turns();
  }

  /// Posts take_turns(), unless that is posted. \returns false if there is no memory for it: the caller must
  /// then process the frames, since nothing else would.
  bool take_turns_soon() {
    if (shared_.turns_are_posted) return true;
    try {
      net::post(socket_.get_executor(), [self = shared_.turn.front()] { self->take_turns(); });
    } catch (const std::bad_alloc&) {
      return false;
    }
    shared_.turns_are_posted = true;
    return true;
  }

  /// Processes as many frames as time permits; urgent ones are processed in between. A frame that runs out of
  /// memory ends its own connection only: those behind it may be emergency stops.
  void take_turns() {
    shared_.turns_are_posted = false;
    const double until = monotonic_now() + kTurnTime;
    std::shared_ptr<SocketSession> next;
    do {
      next = std::move(shared_.turn.front());
      shared_.turn.pop_front();
      do_if_there_is_memory([&] { next->take_frame(); });
    } while (!shared_.turn.empty() && (monotonic_now() < until || !take_turns_soon()));
  }

  void take(const Client::Decoded& decoded) {
    client_.take(decoded);
    buffer_.consume(buffer_.size());
    if (!client_.fault().empty()) return say_goodbye();
    read();
    // The read of a frame that has arrived already was posted before this, and has been counted.
    net::post(socket_.get_executor(), [self = shared_from_this(), seen = frames_] {
      if (seen == self->frames_) self->client_.caught_up();
    });
  }

  /// Called when the client has something to send; sends it once the caller has returned.
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
    // As much as fits is in the kernel's buffer by now.
    if (!client_.has_next()) hold_back(false);
  }

  /// Corks the socket while there is more to send: all pending messages then go out in one packet and wake
  /// the reader once. With many clients on one machine, this leaves processor time to the servo loop.
  void hold_back(bool on) {
    if (held_back_ == on) return;
    held_back_ = on;
    const int value = on ? 1 : 0;
    ::setsockopt(beast::get_lowest_layer(socket_).socket().native_handle(), IPPROTO_TCP, TCP_CORK, &value,
                 sizeof value);
  }

  /// Closes with the reason, if the client still reads.
  void say_goodbye() {
    if (!open_) return;
    open_ = false;
    hold_back(false);
    if (writing_) return close();  // the client does not even read the message being written
    const websocket::close_reason reason(websocket::close_code::policy_error, client_.fault());
    socket_.async_close(reason, [self = shared_from_this()](error_code) { self->close(); });
  }

  Shared& shared_;
  std::unique_ptr<Place> place_;
  /// Without compression: messages are small and latency matters.
  websocket::stream<beast::tcp_stream, false> socket_;
  beast::flat_buffer buffer_;
  Client client_;
  std::shared_ptr<const std::string> sent_;
  std::uint64_t frames_ = 0;  ///< number of frames read
  bool open_ = false, writing_ = false, woken_ = false, held_back_ = false;
};

/// Open connections, longest idle first.
using Crowd = std::list<class HttpSession*>;

/// State shared by all connections that are not WebSockets. Used on the page thread.
struct Pages {
  WebServer::Site site;
  Access access;
  /// Turns a connection into a WebSocket.
  std::function<void(tcp::socket&& socket, const Request& request)> upgrade;
  const std::atomic<std::size_t>& sockets;  ///< number of WebSockets
  WebUploads uploads;
  std::function<void(const std::string& line)> tell;
  bool secure;  ///< connections use TLS
  Crowd strangers, guests;
  bool receives = false;  ///< an upload is in progress
};

/// An HTTP connection, which may become a WebSocket.
class HttpSession final : public std::enable_shared_from_this<HttpSession> {
 public:
  /// \param address of the peer, see address_of()
  HttpSession(Pages& pages, tcp::socket&& socket, std::string address)
      : pages_(pages), address_(std::move(address)), stream_(std::move(socket)) {}
  ~HttpSession() {
    leave();
    drop_file();
  }
  HttpSession(const HttpSession&) = delete;
  HttpSession& operator=(const HttpSession&) = delete;

  void begin() {
    enter(pages_.strangers, WebServer::kMostStrangers);
    read();
  }

  void close() {
    leave();
    stream_.close();
    drop_file();
  }

 private:
  void enter(Crowd& crowd, std::size_t most) {
    leave();
    if (crowd.size() == most) crowd.front()->close();
    crowd.push_back(this);
    crowd_ = &crowd;
    at_ = std::prev(crowd.end());
  }
  void leave() {
    if (crowd_ != nullptr) crowd_->erase(at_);
    crowd_ = nullptr;
  }
  bool is_stranger() const { return crowd_ == &pages_.strangers; }

  /// Restarts the timeout when the peer has sent or received something. A stranger keeps its deadline.
  void progress() {
    if (is_stranger()) {
      stream_.expires_at(until_);
    } else {
      stream_.expires_after(kHttpTimeout);
      if (crowd_ != nullptr) crowd_->splice(crowd_->end(), *crowd_, at_);
    }
  }

  void read() {
    head_.emplace();
    head_->header_limit(kMostHeader);
    head_->body_limit(WebServer::kMostUpload);
    progress();
    http::async_read_header(stream_, buffer_, *head_,
                            [self = shared_from_this()](error_code error, std::size_t) {
                              if (error) return self->close();
                              self->read_body();
                            });
  }

  void read_body() {
    if (crowd_ == nullptr) return;  // closed meanwhile
    if (head_->get().method() == http::verb::put) return begin_upload();
    if (head_->content_length().value_or(0) > kMostBody) return close();
    parser_.emplace(std::move(*head_));
    parser_->body_limit(kMostBody);
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return self->close();
      self->handle(self->parser_->release());
    });
  }

  std::optional<Access::Refused> refusal(const RequestHead& head) {
    auto refused = pages_.access.refusal(head, monotonic_now());
    if (refused && pages_.tell && !refused->notice.empty()) pages_.tell(refused->notice);
    return refused;
  }

  /// \name Upload of a file: nothing of it is read before it is accepted
  /// @{
  void begin_upload() {
    RequestHead head = head_of(head_->get());
    head.address = address_;
    head.logged_in = !is_stranger();
    request_ = {};
    request_.version(head_->get().version());
    request_.keep_alive(false);  // the rest of a refused upload is not read
    if (const auto refused = refusal(head)) return send(request_, text_page(refused->status, refused->why));
    if (is_stranger()) enter(pages_.guests, WebServer::kMostConnections);
    const auto length = head_->content_length();
    const auto path = path_of(head.target);
    if (!pages_.uploads.place || !path || !path->starts_with(pages_.uploads.folder))
      return send(request_, text_page(405, "only GET and HEAD are supported here"));
    if (!length) return send(request_, text_page(411, "the Content-Length header is missing"));
    if (pages_.receives)
      return send(request_, text_page(503, "another upload is in progress; try again later"));
    try {
      file_ = pages_.uploads.place(*path, *length);
    } catch (const std::exception& error) {
      return send(request_, text_page(422, error.what()));
    }
    pages_.receives = true;
    upload_.emplace(std::move(*head_));
    upload_->body_limit(*length);
    error_code error;
    upload_->get().body().open(file_.c_str(), beast::file_mode::write_new, error);
    if (error) return close();
    receive();
  }

  /// Receives the rest of the file: nothing, if it is empty.
  void receive() {
    if (upload_->is_done()) return end_upload();
    progress();
    http::async_read_some(stream_, buffer_, *upload_,
                          [self = shared_from_this()](error_code error, std::size_t) {
                            if (error) return self->close();
                            self->receive();
                          });
  }

  void end_upload() {
    upload_.reset();  // closes the file
    const std::string file = std::exchange(file_, {});
    pages_.receives = false;
    try {
      send(request_, pages_.uploads.have(file));
    } catch (const std::exception& error) {
      pages_.uploads.drop(file);
      send(request_, text_page(422, error.what()));
    }
  }

  void drop_file() {
    if (file_.empty()) return;
    upload_.reset();
    pages_.receives = false;
    pages_.uploads.drop(std::exchange(file_, {}));
  }
  /// @}

  void handle(const Request& request) {
    if (crowd_ == nullptr) return;  // closed meanwhile
    RequestHead head = head_of(request);
    head.address = address_;
    head.logged_in = !is_stranger();
    if (const auto refused = refusal(head)) return send(request, text_page(refused->status, refused->why));
    if (websocket::is_upgrade(request)) return upgrade(request);
    if (is_stranger()) enter(pages_.guests, WebServer::kMostConnections);
    if (request.method() != http::verb::get && request.method() != http::verb::head)
      return send(request, text_page(405, "only GET and HEAD are supported here"));
    const auto path = path_of(head.target);
    brings_token_ = pages_.access.has_token_in_target(head);
    send(request, path ? page_at(*path, head.target) : text_page(400, "invalid path"));
  }

  void upgrade(const Request& request) {
    if (pages_.sockets == WebServer::kMostClients)
      return send(request, text_page(503, "too many clients are connected"));
    leave();
    stream_.expires_never();
    pages_.upgrade(stream_.release_socket(), request);
  }

  /// Returns the page. An HTML page requested with the token is redirected to the URL without it, so that the
  /// token stays out of the address bar, the history, and copied links.
  WebPage page_at(const std::string& path, std::string_view target) const {
    WebPage page = pages_.site(path);
    const bool elsewhere_by_slashes = target.starts_with("//");  // would redirect to another host
    if (!brings_token_ || !page.type.starts_with("text/html") || elsewhere_by_slashes) return page;
    WebPage moved = text_page(303, "redirect without the token");
    moved.location = without_query_value(target, "token");
    return moved;
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
    if (!page_.location.empty()) answer_.set(http::field::location, page_.location);
    if (page_.retry_after > 0) answer_.set(http::field::retry_after, std::to_string(page_.retry_after));
    give_cookie();
    rest_ = {0, size()};
    if (!page_.tag.empty()) {
      const std::string tag = '"' + page_.tag + '"';
      answer_.set(http::field::etag, tag);
      answer_.set(http::field::cache_control, "no-cache");  // stored, and validated before each use
      answer_.set(http::field::accept_ranges, "bytes");
      rest_ = part(request, tag);
    } else {
      answer_.set(http::field::cache_control, "no-store");
      answer_.result(static_cast<unsigned>(page_.status));
    }
    if (answer_.result() != http::status::not_modified) answer_.content_length(rest_.count);
    if (request.method() == http::verb::head) rest_.count = 0;
    progress();
    serializer_.emplace(answer_);
    http::async_write_header(stream_, *serializer_,
                             [self = shared_from_this()](error_code error, std::size_t) {
                               error ? self->close() : self->write_some();
                             });
  }

  /// Writes in pieces, so that only a peer that reads nothing at all times out, and not a slow one.
  void write_some() {
    if (piece_.empty() && rest_.count == 0) return done();
    if (piece_.empty() && !take_piece()) return close();
    progress();
    const auto written = [self = shared_from_this()](error_code error, std::size_t count) {
      if (error) return self->close();
      self->piece_.remove_prefix(count);
      self->write_some();
    };
    stream_.async_write_some(net::buffer(piece_.data(), piece_.size()), written);
  }

  /// Takes the next piece of the page. \returns false if a file is truncated or cannot be read.
  bool take_piece() {
    constexpr std::size_t kPiece = 1 << 18;
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, rest_.count));
    if (page_.file) {
      file_bytes_.resize(count);
      try {
        page_.file->read(rest_.first, file_bytes_);
      } catch (const Error&) {
        return false;
      }
      piece_ = {file_bytes_.data(), count};
    } else {
      piece_ = page_.bytes.substr(rest_.first, count);
    }
    rest_ = {rest_.first + count, rest_.count - count};
    return true;
  }

  void done() {
    const bool goes_on = answer_.keep_alive();
    const bool unread = !goes_on && head_ && head_->get().method() == http::verb::put;
    serializer_.reset();
    page_ = {};
    file_bytes_ = {};
    if (unread) return drain();
    goes_on ? read() : close();
  }

  /// A peer that is still sending a refused file would lose the response if the connection were closed at
  /// once.
  void drain() {
    error_code ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    stream_.expires_after(kDrain);
    drain_some();
  }

  void drain_some() {
    buffer_.clear();
    stream_.async_read_some(buffer_.prepare(kMostHeader),
                            [self = shared_from_this()](error_code error, std::size_t) {
                              error ? self->close() : self->drain_some();
                            });
  }

  std::uint64_t size() const { return page_.file ? page_.file->size() : page_.bytes.size(); }

  /// Returns the part of the page that is requested, and sets the status.
  ByteRange part(const Request& request, const std::string& tag) {
    const std::string_view known = view(request[http::field::if_none_match]);
    if (known == "*" || known.find(tag) != std::string_view::npos) {
      answer_.result(http::status::not_modified);
      return {};
    }
    const std::string_view condition = view(request[http::field::if_range]);
    const bool whole = (!condition.empty() && condition != tag) || request.method() == http::verb::head;
    const RangeRequest asked =
        whole ? RangeRequest{} : parse_range(view(request[http::field::range]), size());
    answer_.result(static_cast<unsigned>(page_.status));
    if (asked.kind == RangeRequest::Kind::kNone) return {0, size()};
    if (asked.kind == RangeRequest::Kind::kUnsatisfiable) {
      answer_.result(http::status::range_not_satisfiable);
      answer_.set(http::field::content_range, fmt::format("bytes */{}", size()));
      return {};
    }
    const auto [first, count] = asked.range;
    answer_.result(http::status::partial_content);
    answer_.set(http::field::content_range, fmt::format("bytes {}-{}/{}", first, first + count - 1, size()));
    return asked.range;
  }

  /// Sets the session cookie for a client that presented the token: a page cannot add the token to all that
  /// it loads. SameSite=Lax: also after following a link to here.
  void give_cookie() {
    if (brings_token_)
      answer_.set(http::field::set_cookie, pages_.access.cookie() + "; Path=/; HttpOnly; SameSite=Lax" +
                                               (pages_.secure ? "; Secure" : ""));
    brings_token_ = false;
  }

  using Answer = http::response<http::empty_body>;

  Pages& pages_;
  std::string address_;
  Crowd* crowd_ = nullptr;  ///< list that contains it; null: closed, or upgraded
  Crowd::iterator at_;
  /// Deadline of a stranger.
  std::chrono::steady_clock::time_point until_ =
      std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                             std::chrono::duration<double>(WebServer::kStrangerTime));
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::empty_body>>
      head_;  ///< header of a request, until its body is read
  std::optional<http::request_parser<http::string_body>> parser_;
  std::optional<http::request_parser<http::file_body>> upload_;
  Request request_;   ///< what the response to an upload needs of its request
  std::string file_;  ///< being received
  bool brings_token_ = false;
  WebPage page_;
  Answer answer_;
  std::optional<http::response_serializer<http::empty_body>> serializer_;
  ByteRange rest_;          ///< part of the page not yet taken
  std::string_view piece_;  ///< part taken but not yet written
  std::vector<char> file_bytes_;
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
      : shared_{hub,
                [this](auto work, auto then) { have_done(decoder_, std::move(work), std::move(then)); },
                {},
                {},
                false},
        real_time_(options.real_time),
        acceptor_(web_.context()),
        address_(options.address),
        retry_(web_.context()) {
    if (!options.tls_certificate.empty()) tls_.emplace(options.tls_certificate, options.tls_key);
    listen(options);
    pages_.emplace(
        Pages{std::move(site),
              Access(options.address, port_, options.token, random_text()),
              [this](tcp::socket&& socket, const Request& request) { upgrade(std::move(socket), request); },
              sockets_,
              options.uploads,
              options.tell,
              tls_.has_value(),
              {},
              {}});
  }

  void every(double rate, std::function<void()> work) {
    timers_.push_back({net::steady_timer(own_.context()),
                       std::chrono::nanoseconds(static_cast<long>(1e9 / rate)), std::move(work)});
  }

  void when(Wake& wake, std::function<void()> work) {
    watches_.push_back({net::posix::stream_descriptor(own_.context(), wake.descriptor()), std::move(work)});
  }

  void start() {
    accept();
    for (Timer& timer : timers_) {
      timer.timer.expires_after(timer.period);
      wait(timer);
    }
    for (Watch& watch : watches_) wait(watch);
    own_.start("palpate-gateway", real_time_);
    web_.start("palpate-pages");
    if (tls_) tls_->start();
    decoder_.start("palpate-decode");
    worker_.start("palpate-slow");
  }

  void stop() {
    if (own_.is_running()) {
      if (tls_) tls_->stop();
      net::post(web_.context(), [this] { close_pages(); });
      web_.finish();
      net::post(own_.context(), [this] { close_sockets(); });
      own_.finish();
      decoder_.stop();
      worker_.stop();
      shared_.turn.clear();
    }
    for (Watch& watch : watches_) watch.descriptor.release();  // owned by the Wake
    watches_.clear();
  }

  void post(std::function<void()> work) { net::post(own_.context(), std::move(work)); }
  void elsewhere(std::function<void()> work, std::function<void()> then) {
    have_done(worker_, std::move(work), std::move(then));
  }
  std::uint16_t port() const { return port_; }
  const char* scheme() const { return tls_ ? "https" : "http"; }
  const std::string& address() const { return address_; }
  const std::string& token() const { return pages_->access.token(); }

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

  void listen(const WebServerOptions& options) {
    error_code error;
    const auto address = net::ip::make_address(options.address, error);
    if (error)
      throw Error("{}: is not an IP address; give one of this machine to listen on", options.address);
    const tcp::endpoint endpoint(address, options.port);
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(net::socket_base::max_listen_connections, error);
    if (error) refuse(options, error);
    protocol_ = endpoint.protocol();
    port_ = acceptor_.local_endpoint().port();
  }

  /// \throws Error with the reason for which the server cannot listen, and what to change.
  [[noreturn]] static void refuse(const WebServerOptions& options, const error_code& error) {
    namespace errc = boost::system::errc;
    if (error == errc::address_not_available || error == errc::address_family_not_supported) {
      throw Error(
          "cannot listen on {}: this machine has no such address; give --listen one of its own, or 0.0.0.0 "
          "for all of them",
          options.address);
    }
    if (options.port == 0) {
      throw Error("cannot listen on {}: {}; give another --listen, or --no-gateway", options.address,
                  error.message());
    }
    throw Error("cannot listen on {} port {}: {}; give another --port, or --no-gateway", options.address,
                options.port, error.message());
  }

  void have_done(Lane& lane, std::function<void()> work, std::function<void()> then) {
    net::post(lane.context(), [this, work = std::move(work), then = std::move(then)]() mutable {
      do_if_there_is_memory(work);
      work = nullptr;
      net::post(own_.context(), std::move(then));
    });
  }

  void close_pages() {
    error_code ignored;
    acceptor_.close(ignored);
    retry_.cancel();
    ends_ = true;
    for (Crowd* crowd : {&pages_->strangers, &pages_->guests}) {
      while (!crowd->empty()) crowd->front()->close();
    }
  }

  void close_sockets() {
    error_code ignored;
    for (Timer& timer : timers_) timer.timer.cancel();
    for (Watch& watch : watches_) watch.descriptor.cancel(ignored);
    stops_ = true;
    const std::set<SocketSession*> open = shared_.sessions;
    for (SocketSession* session : open) session->close();
  }

  void accept() {
    acceptor_.async_accept([this](error_code error, tcp::socket socket) {
      if (ends_ || error == net::error::operation_aborted) return;
      if (error) {  // for example no free descriptors: retried later
        retry_.expires_after(std::chrono::milliseconds(100));
        retry_.async_wait([this](error_code cancelled) {
          if (!cancelled) accept();
        });
        return;
      }
      error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      do_if_there_is_memory([&] { take(std::move(socket)); });  // else that connection ends
      accept();
    });
  }

  void take(tcp::socket&& socket) {
    std::string address = address_of(socket);
    if (!tls_) return begin(std::move(socket), std::move(address));
    tls_->take(socket.release(), [this, address = std::move(address)](int descriptor) {
      net::post(web_.context(),
                [this, address, plain = tcp::socket(web_.context(), protocol_, descriptor)]() mutable {
                  if (!ends_) begin(std::move(plain), std::move(address));
                });
    });
  }

  void begin(tcp::socket&& socket, std::string address) {
    std::make_shared<HttpSession>(*pages_, std::move(socket), std::move(address))->begin();
  }

  /// Moves a connection from the page thread to the server's.
  void upgrade(tcp::socket&& socket, const Request& request) {
    tcp::socket moved(own_.context(), protocol_, socket.release());
    auto work = [this, moved = std::move(moved), request,
                 place = std::make_unique<Place>(sockets_)]() mutable {
      std::make_shared<SocketSession>(shared_, std::move(moved), std::move(place))->accept(request);
    };
    net::post(own_.context(), std::move(work));
  }

  void wait(Timer& timer) {
    timer.timer.async_wait([this, &timer](error_code error) {
      if (error || stops_) return;
      do_if_there_is_memory(timer.work);
      // Relative to the due time, to keep the rate; missed calls are skipped.
      const auto next = timer.timer.expiry() + timer.period;
      timer.timer.expires_at(std::max(next, std::chrono::steady_clock::now()));
      wait(timer);
    });
  }

  void wait(Watch& watch) {
    watch.descriptor.async_wait(net::posix::stream_descriptor::wait_read, [this, &watch](error_code error) {
      if (error || stops_) return;
      do_if_there_is_memory(watch.work);
      wait(watch);
    });
  }

  // Used by pending work of the lanes, which they must outlive.
  std::atomic<std::size_t> sockets_ = 0;  ///< incremented on the page thread only
  Shared shared_;
  std::optional<Pages> pages_;
  Lane own_, web_, decoder_, worker_;
  std::optional<ThreadPriority> real_time_;
  std::optional<TlsRelay> tls_;
  tcp::acceptor acceptor_;
  tcp protocol_ = tcp::v4();
  std::string address_;
  std::uint16_t port_ = 0;
  net::steady_timer retry_;
  std::list<Timer> timers_;
  std::list<Watch> watches_;
  bool ends_ = false;   ///< used on the page thread
  bool stops_ = false;  ///< used on the server's thread
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
void WebServer::elsewhere(std::function<void()> work, std::function<void()> then) {
  implementation_->elsewhere(std::move(work), std::move(then));
}
std::uint16_t WebServer::port() const { return implementation_->port(); }

std::string WebServer::url() const {
  std::string address = implementation_->address();
  if (is_any_address(address)) address = net::ip::host_name();
  const bool six = address.find(':') != std::string::npos;
  const std::string& token = implementation_->token();
  return fmt::format("{}://{}:{}/{}", implementation_->scheme(), six ? '[' + address + ']' : address, port(),
                     token.empty() ? "" : "?token=" + token);
}

}  // namespace palpate

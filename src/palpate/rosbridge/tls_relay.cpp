#include <palpate/rosbridge/tls_relay.h>

#include <palpate/rosbridge/lane.h>

#include <array>
#include <chrono>
#include <list>
#include <set>
#include <vector>

#include <sys/socket.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>

#include <palpate/base/error.h>
#include <palpate/base/file.h>

namespace palpate {
namespace {

namespace net = boost::asio;
using boost::system::error_code;
using net::ip::tcp;
using Near = net::local::stream_protocol;

/// Time for a peer to confirm the end of the connection.
constexpr auto kGoodbye = std::chrono::seconds(1);
constexpr std::size_t kRecord = 16 << 10;  // a TLS record. Unit: [bytes].

class Connection;

/// Open connections. Used on the relay's thread.
struct Connections {
  std::set<Connection*> all;
  std::list<Connection*> handshakes;  ///< oldest first
};

/// A connection to a peer, and the socket pair to the server.
class Connection final : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Connections& others, net::io_context& context, net::ssl::context& tls, tcp::socket&& socket)
      : others_(others), far_(std::move(socket), tls), near_(context), deadline_(context) {
    others_.all.insert(this);
  }
  ~Connection() {
    others_.all.erase(this);
    others_.handshakes.remove(this);
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void begin(std::function<void(int)> plain) {
    if (others_.handshakes.size() == TlsRelay::kMostHandshakes) others_.handshakes.front()->close();
    others_.handshakes.push_back(this);
    close_after(std::chrono::duration_cast<std::chrono::steady_clock::duration>(
        std::chrono::duration<double>(TlsRelay::kHandshakeTime)));
    far_.async_handshake(net::ssl::stream_base::server,
                         [self = shared_from_this(), plain = std::move(plain)](error_code error) {
                           self->others_.handshakes.remove(self.get());
                           if (error || !self->connect(plain)) return self->close();
                           self->decrypt();
                           self->encrypt();
                         });
  }

  void close() {
    error_code ignored;
    others_.handshakes.remove(this);
    deadline_.cancel();
    far_.next_layer().close(ignored);
    near_.close(ignored);
  }

 private:
  bool connect(const std::function<void(int)>& plain) {
    deadline_.cancel();
    std::array<int, 2> ends{};
    if (!far_.next_layer().is_open() ||
        ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
      return false;
    near_.assign(Near(), ends[0]);
    plain(ends[1]);
    return true;
  }

  void close_after(std::chrono::steady_clock::duration time) {
    deadline_.expires_after(time);
    deadline_.async_wait([weak = weak_from_this()](error_code cancelled) {
      const auto self = weak.lock();
      if (!cancelled && self) self->close();
    });
  }

  /// Forwards from the peer to the server, including the end of the stream.
  void decrypt() {
    far_.async_read_some(net::buffer(plain_), [self = shared_from_this()](error_code error,
                                                                          std::size_t count) {
      error_code ignored;
      if (error) {
        self->near_.shutdown(Near::socket::shutdown_send, ignored);
        return;
      }
      net::async_write(self->near_, net::buffer(self->plain_, count),
                       [self](error_code failed, std::size_t) { failed ? self->close() : self->decrypt(); });
    });
  }

  /// Forwards from the server to the peer. The end of the server's stream closes the connection.
  void encrypt() {
    near_.async_read_some(net::buffer(sent_), [self = shared_from_this()](error_code error,
                                                                          std::size_t count) {
      if (error) return self->say_goodbye();
      net::async_write(self->far_, net::buffer(self->sent_, count),
                       [self](error_code failed, std::size_t) { failed ? self->close() : self->encrypt(); });
    });
  }

  void say_goodbye() {
    close_after(kGoodbye);
    far_.async_shutdown([self = shared_from_this()](error_code) { self->close(); });
  }

  Connections& others_;
  net::ssl::stream<tcp::socket> far_;
  Near::socket near_;
  net::steady_timer deadline_;
  std::array<char, kRecord> plain_{}, sent_{};
};

/// \throws Error
void load(net::ssl::context& tls, const std::string& certificate, const std::string& key) {
  for (const std::string& path : {certificate, key})
    (void)InputFile(path);  // reports why the file cannot be read
  error_code error;
  // Without this, OpenSSL asks for a password on the terminal.
  tls.set_password_callback([](std::size_t, net::ssl::context::password_purpose) { return std::string(); },
                            error);
  tls.use_certificate_chain_file(certificate, error);
  if (error) throw Error("{}: --tls-cert is not a PEM certificate ({})", certificate, error.message());
  tls.use_private_key_file(key, net::ssl::context::pem, error);
  const bool other =
      error && ERR_GET_REASON(static_cast<unsigned long>(error.value())) == X509_R_KEY_VALUES_MISMATCH;
  if (error && !other)
    throw Error("{}: --tls-key is not a PEM private key without a password ({})", key, error.message());
  if (other || ::SSL_CTX_check_private_key(tls.native_handle()) != 1)
    throw Error("{}: --tls-key does not match the certificate {}; give the key of that certificate", key,
                certificate);
}

}  // namespace

class TlsRelay::Implementation {
 public:
  Implementation(const std::string& certificate, const std::string& key) {
    ::SSL_CTX_set_min_proto_version(tls_.native_handle(), TLS1_2_VERSION);
    load(tls_, certificate, key);
  }

  void start() { lane_.start("palpate-tls"); }

  void stop() {
    if (!lane_.is_running()) return;
    net::post(lane_.context(), [this] {
      ends_ = true;
      const std::vector<Connection*> open(connections_.all.begin(), connections_.all.end());
      for (Connection* connection : open) connection->close();
    });
    lane_.finish();
  }

  void take(int socket, std::function<void(int)> plain) {
    tcp::socket far(lane_.context(), tcp::v4(), socket);
    net::post(lane_.context(), [this, far = std::move(far), plain = std::move(plain)]() mutable {
      if (ends_) return;
      std::make_shared<Connection>(connections_, lane_.context(), tls_, std::move(far))
          ->begin(std::move(plain));
    });
  }

 private:
  // Used by pending work of the lane, which they must outlive.
  Connections connections_;
  net::ssl::context tls_{net::ssl::context::tls_server};
  bool ends_ = false;
  Lane lane_;
};

TlsRelay::TlsRelay(const std::string& certificate, const std::string& key)
    : implementation_(std::make_unique<Implementation>(certificate, key)) {}
TlsRelay::~TlsRelay() { stop(); }
void TlsRelay::start() { implementation_->start(); }
void TlsRelay::stop() { implementation_->stop(); }
void TlsRelay::take(int socket, std::function<void(int descriptor)> plain) {
  implementation_->take(socket, std::move(plain));
}

}  // namespace palpate

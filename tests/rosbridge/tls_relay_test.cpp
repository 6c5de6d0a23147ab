// TlsRelay between a client of OpenSSL and a pair of plain sockets, with certificates that are made here.
#include <palpate/rosbridge/tls_relay.h>

#include <chrono>
#include <deque>
#include <future>
#include <string>
#include <string_view>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <palpate/base/clock.h>
#include <palpate/base/error.h>
#include <palpate/rosbridge/web_server.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using test::message_of;
using testing::AllOf;
using testing::HasSubstr;

/// Longer than anything takes, so that a test fails rather than hangs.
constexpr double kLongestWait = 60.0;

struct Key {
  explicit Key(EVP_PKEY* made = EVP_EC_gen("P-256")) : key(made) {}
  ~Key() { EVP_PKEY_free(key); }
  Key(const Key&) = delete;
  Key& operator=(const Key&) = delete;

  EVP_PKEY* key;
};

/// What `write` writes.
template <class Write>
std::string pem(const Write& write) {
  BIO* const out = BIO_new(BIO_s_mem());
  EXPECT_EQ(write(out), 1);
  char* text = nullptr;
  const long size = BIO_get_mem_data(out, &text);
  std::string result(text, static_cast<std::size_t>(size));
  BIO_free(out);
  return result;
}

/// With a password, if there is one.
std::string pem_of(const Key& key, const char* password = nullptr) {
  return pem([&](BIO* out) {
    return PEM_write_bio_PKCS8PrivateKey(out, key.key, password == nullptr ? nullptr : EVP_aes_128_cbc(),
                                         password, password == nullptr ? 0 : 4, nullptr, nullptr);
  });
}

/// Of itself.
std::string certificate_of(const Key& key) {
  X509* const x509 = X509_new();
  ASN1_INTEGER_set(X509_get_serialNumber(x509), 1);
  X509_gmtime_adj(X509_getm_notBefore(x509), -60);
  X509_gmtime_adj(X509_getm_notAfter(x509), 3600);
  X509_set_pubkey(x509, key.key);
  X509_NAME* const name = X509_get_subject_name(x509);
  X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>("palpate"), -1,
                             -1, 0);
  X509_set_issuer_name(x509, name);
  EXPECT_GT(X509_sign(x509, key.key, EVP_sha256()), 0);
  std::string result = pem([&](BIO* out) { return PEM_write_bio_X509(out, x509); });
  X509_free(x509);
  return result;
}

void limit_waiting(int socket) {
  timeval limit{static_cast<time_t>(kLongestWait), 0};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  ::setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
}

/// A socket that is closed at last.
class Socket {
 public:
  explicit Socket(int descriptor) : descriptor_(descriptor) { limit_waiting(descriptor); }
  ~Socket() { end(); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  int descriptor() const { return descriptor_; }
  void end() {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
  }

  bool send(std::string_view bytes) const {
    while (!bytes.empty()) {
      const ssize_t n = ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
  }
  /// So many bytes, or what there is before the end.
  std::string read(std::size_t count) const {
    std::string result(count, '\0');
    std::size_t size = 0;
    while (size < count) {
      const ssize_t n = ::recv(descriptor_, &result[size], count - size, 0);
      if (n <= 0) break;
      size += static_cast<std::size_t>(n);
    }
    result.resize(size);
    return result;
  }
  /// Whatever comes before the end. Fails if that does not come.
  void read_all() const {
    while (!ends()) continue;
  }
  /// True if the peer has ended, and sent nothing more.
  bool ends() const {
    char byte = 0;
    const double begin = monotonic_now();
    const ssize_t n = ::recv(descriptor_, &byte, 1, 0);
    EXPECT_LT(monotonic_now() - begin, 0.9 * kLongestWait) << "it stays open";
    return n <= 0;
  }

 private:
  int descriptor_;
};

/// A client of TLS on a connected socket.
class Peer {
 public:
  explicit Peer(int socket, int version = 0) : socket_(socket), context_(SSL_CTX_new(TLS_client_method())) {
    if (version != 0) {
      SSL_CTX_set_security_level(context_, 0);
      SSL_CTX_set_min_proto_version(context_, version);
      SSL_CTX_set_max_proto_version(context_, version);
    }
    ssl_ = SSL_new(context_);
    SSL_set_fd(ssl_, socket);
  }
  ~Peer() {
    SSL_free(ssl_);
    SSL_CTX_free(context_);
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  bool connect() { return SSL_connect(ssl_) == 1; }
  bool send(std::string_view bytes) {
    return SSL_write(ssl_, bytes.data(), static_cast<int>(bytes.size())) > 0;
  }
  std::string read(std::size_t count) {
    std::string result(count, '\0');
    std::size_t size = 0;
    while (size < count) {
      const int n = SSL_read(ssl_, &result[size], static_cast<int>(count - size));
      if (n <= 0) break;
      size += static_cast<std::size_t>(n);
    }
    result.resize(size);
    return result;
  }
  /// True if the peer says that it has ended, which nobody can do in its place.
  bool is_told_the_end() {
    char byte = 0;
    const int n = SSL_read(ssl_, &byte, 1);
    return n <= 0 && SSL_get_error(ssl_, n) == SSL_ERROR_ZERO_RETURN;
  }
  void say_goodbye() { SSL_shutdown(ssl_); }
  Socket& socket() { return socket_; }

 private:
  Socket socket_;
  SSL_CTX* context_;
  SSL* ssl_;
};

class TlsRelayTest : public testing::Test {
 protected:
  TlsRelayTest()
      : certificate_(certificate_of(key_)),
        key_file_(pem_of(key_)),
        listener_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::bind(listener_.descriptor(), reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
    EXPECT_EQ(::listen(listener_.descriptor(), 64), 0);
    relay_.start();
  }

  /// A peer's end of a connection whose other one the relay has.
  int connect() {
    sockaddr_in to{};
    socklen_t size = sizeof to;
    ::getsockname(listener_.descriptor(), reinterpret_cast<sockaddr*>(&to), &size);
    const int peer = ::socket(AF_INET, SOCK_STREAM, 0);
    EXPECT_EQ(::connect(peer, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    plain_.emplace_back();
    relay_.take(::accept(listener_.descriptor(), nullptr, nullptr),
                [&promise = plain_.back()](int descriptor) { promise.set_value(descriptor); });
    return peer;
  }
  /// The server's end of the last connection.
  int plain() {
    std::future<int> future = plain_.back().get_future();
    EXPECT_EQ(future.wait_for(std::chrono::duration<double>(kLongestWait)), std::future_status::ready);
    return future.get();
  }

  Key key_;
  test::TemporaryFile certificate_, key_file_;
  Socket listener_;
  std::deque<std::promise<int>> plain_;
  TlsRelay relay_{certificate_.path(), key_file_.path()};
};

std::string many_bytes() {
  std::string bytes(1 << 20, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 2654435761U >> 24U);
  return bytes;
}

TEST_F(TlsRelayTest, WhatGoesInComesOut) {
  Peer client(connect());
  ASSERT_TRUE(client.connect());
  const Socket server(plain());
  for (const std::string& bytes : {std::string("hello"), many_bytes()}) {
    auto sends = std::async(std::launch::async, [&] { return client.send(bytes); });
    EXPECT_TRUE(server.read(bytes.size()) == bytes);
    EXPECT_TRUE(sends.get());
    auto answers = std::async(std::launch::async, [&] { return server.send(bytes); });
    EXPECT_TRUE(client.read(bytes.size()) == bytes);
    EXPECT_TRUE(answers.get());
  }
}

// In the air, that is: what a third sees of it are records of TLS.
TEST_F(TlsRelayTest, NothingIsSentAsItIs) {
  Peer client(connect());
  ASSERT_TRUE(client.connect());
  const Socket server(plain());
  ASSERT_TRUE(server.send("."));
  EXPECT_EQ(client.read(1), ".") << "past what TLS has to say itself";
  ASSERT_TRUE(server.send("a secret that is long enough to be found again"));
  const std::string record = client.socket().read(60);
  EXPECT_EQ(record.size(), 60U);
  EXPECT_EQ(record.find("secret"), std::string::npos);
}

TEST_F(TlsRelayTest, AnEndIsToldToTheOtherSide) {
  {
    Peer client(connect());
    ASSERT_TRUE(client.connect());
    Socket server(plain());
    ASSERT_TRUE(server.send("last words"));
    server.end();
    EXPECT_EQ(client.read(10), "last words");
    EXPECT_TRUE(client.is_told_the_end());
    EXPECT_TRUE(client.socket().ends()) << "and then it is closed, whether that has answered or not";
  }
  Peer client(connect());
  ASSERT_TRUE(client.connect());
  const Socket server(plain());
  ASSERT_TRUE(client.send("last words"));
  client.say_goodbye();
  EXPECT_EQ(server.read(11), "last words") << "and no more";
  ASSERT_TRUE(server.send("an answer"));
  EXPECT_EQ(client.read(9), "an answer") << "which still comes";
}

TEST_F(TlsRelayTest, WhatIsCutIsAnEndToo) {
  Peer client(connect());
  ASSERT_TRUE(client.connect());
  const Socket server(plain());
  client.socket().end();
  EXPECT_TRUE(server.ends());
}

TEST_F(TlsRelayTest, WhatIsNoTlsIsClosed) {
  const Socket peer(connect());
  ASSERT_TRUE(peer.send("GET / HTTP/1.1\r\n\r\n"));
  peer.read_all();
  EXPECT_EQ(plain_.back().get_future().wait_for(std::chrono::seconds(0)), std::future_status::timeout);
}

// RFC 8996: older versions are not to be used.
TEST_F(TlsRelayTest, SpeaksNoOldVersions) {
  for (const int version : {TLS1_VERSION, TLS1_1_VERSION}) EXPECT_FALSE(Peer(connect(), version).connect());
  for (const int version : {TLS1_2_VERSION, TLS1_3_VERSION}) EXPECT_TRUE(Peer(connect(), version).connect());
}

// Of those that say nothing the oldest makes room for the next, and none stays for ever; who is in is in.
TEST_F(TlsRelayTest, WhoIsSilentLocksNobodyOut) {
  Peer first(connect());
  ASSERT_TRUE(first.connect());
  const Socket server(plain());
  const double begin = monotonic_now();
  std::deque<Socket> silent;
  for (std::size_t k = 0; k < TlsRelay::kMostHandshakes; ++k) silent.emplace_back(connect());
  Peer late(connect());
  ASSERT_TRUE(late.connect());
  EXPECT_TRUE(silent.front().ends());
  EXPECT_LT(monotonic_now() - begin, TlsRelay::kHandshakeTime) << "at once, to make room";
  for (const Socket& socket : silent) EXPECT_TRUE(socket.ends());
  EXPECT_GE(monotonic_now() - begin, 0.9 * TlsRelay::kHandshakeTime) << "the others had their time";
  for (Peer* client : {&first, &late}) {
    const Socket& end = client == &first ? server : silent.emplace_back(plain());
    ASSERT_TRUE(client->send("still here"));
    EXPECT_EQ(end.read(10), "still here");
  }
}

TEST_F(TlsRelayTest, StoppingClosesAll) {
  Peer client(connect());
  ASSERT_TRUE(client.connect());
  const Socket server(plain()), silent(connect());
  relay_.stop();
  client.socket().read_all();
  EXPECT_TRUE(server.ends());
  EXPECT_TRUE(silent.ends());
  relay_.stop();  // once more does no harm
}

TEST(TlsRelayFiles, AreTheTwoThatWereMadeTogether) {
  const Key key, other;
  const test::TemporaryFile certificate(certificate_of(key)), good(pem_of(key)), wrong(pem_of(other)),
      locked(pem_of(key, "1234")), nonsense("nonsense");
  const auto complaint = [](const std::string& cert, const std::string& private_key) {
    return message_of<Error>([&] { TlsRelay(cert, private_key); });
  };
  EXPECT_NO_THROW(TlsRelay(certificate.path(), good.path()));
  EXPECT_THAT(complaint(nonsense.path(), good.path()),
              AllOf(HasSubstr(nonsense.path()), HasSubstr("--tls-cert is not a PEM certificate")));
  EXPECT_THAT(complaint(good.path(), good.path()), HasSubstr("--tls-cert is not a PEM certificate"));
  EXPECT_THAT(complaint(certificate.path(), nonsense.path()),
              AllOf(HasSubstr(nonsense.path()), HasSubstr("--tls-key is not a PEM private key")));
  EXPECT_THAT(complaint(certificate.path(), locked.path()), HasSubstr("without a password"));
  EXPECT_THAT(complaint(certificate.path(), wrong.path()),
              AllOf(HasSubstr("does not match the certificate"), HasSubstr(certificate.path())));
  const Key of_another_kind(EVP_RSA_gen(2048));
  const test::TemporaryFile rsa(pem_of(of_another_kind));
  EXPECT_THAT(complaint(certificate.path(), rsa.path()), HasSubstr("does not match the certificate"));
  for (const bool of_key : {false, true}) {
    const std::string gone = good.path() + "-gone";
    EXPECT_THAT(complaint(of_key ? certificate.path() : gone, of_key ? gone : good.path()), HasSubstr(gone));
  }
}

TEST(WebServerOverTls, ServesPagesAndItsCookieIsForTlsAlone) {
  const Key key;
  const test::TemporaryFile certificate(certificate_of(key)), key_file(pem_of(key));
  Hub hub;
  WebServerOptions options;
  options.port = 0;
  options.token = "0123456789abcdef";
  options.tls_certificate = certificate.path();
  options.tls_key = key_file.path();
  WebServer server(
      hub, [](const std::string& path) { return text_page(200, path); }, options);
  EXPECT_THAT(server.url(), testing::StartsWith("https://127.0.0.1:"));
  server.start();
  const auto connect = [&] {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(server.port());
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
    EXPECT_EQ(::connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    return socket;
  };
  Peer peer(connect());
  ASSERT_TRUE(peer.connect());
  ASSERT_TRUE(peer.send("GET /a?token=0123456789abcdef HTTP/1.1\r\nHost: 127.0.0.1:" +
                        std::to_string(server.port()) + "\r\nConnection: close\r\n\r\n"));
  const std::string answer = peer.read(1 << 16);
  EXPECT_THAT(answer, AllOf(testing::StartsWith("HTTP/1.1 "), HasSubstr("Set-Cookie: palpate-"),
                            HasSubstr("; Secure")));
  const Socket plain(connect());
  ASSERT_TRUE(plain.send("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"));
  EXPECT_THAT(plain.read(9), testing::Not(HasSubstr("HTTP"))) << "nothing without TLS";
  server.stop();
}

}  // namespace
}  // namespace palpate

// WebServer by real connections over the loopback interface, with clients written by hand, so that they may
// be as bad as one likes.
#include <palpate/rosbridge/web_server.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <palpate/base/clock.h>
#include <palpate/base/error.h>
#include <palpate/rosbridge/own_address.h>
#include <support/allocation_guard.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using test::message_of;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// Longer than anything takes on a machine that does much else, so that a test fails rather than hangs.
constexpr double kLong = 60.0;

struct Response {
  int status = 0;  ///< 0: none came
  std::string line, body;
  std::map<std::string, std::string> headers;  ///< by name in lower case

  std::string operator[](const std::string& name) const {
    const auto at = headers.find(name);
    return at == headers.end() ? "" : at->second;
  }
};

/// A client's end of a connection.
class Connection {
 public:
  /// \param from which of this machine's own addresses, 127.x.y.z, it comes from
  explicit Connection(std::uint16_t port, const char* from = "127.0.0.1")
      : Connection(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in own{};
    own.sin_family = AF_INET;
    ::inet_pton(AF_INET, from, &own.sin_addr);
    ::bind(socket_, reinterpret_cast<const sockaddr*>(&own), sizeof own);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
  }
  /// Over IPv6, from ::1 to ::1.
  static std::unique_ptr<Connection> of_ipv6(std::uint16_t port) {
    std::unique_ptr<Connection> made(new Connection(::socket(AF_INET6, SOCK_STREAM, 0)));
    sockaddr_in6 to{};
    to.sin6_family = AF_INET6;
    to.sin6_port = htons(port);
    to.sin6_addr = in6addr_loopback;
    made->connected_ = ::connect(made->socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
    return made;
  }
  ~Connection() { ::close(socket_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  bool is_connected() const { return connected_; }

  /// False where the peer takes it no longer.
  bool send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t n = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
  }

  /// Exactly so many, or fewer where it ends.
  std::string read(std::size_t count) {
    while (got_.size() < count && receive()) continue;
    std::string result = got_.substr(0, count);
    got_.erase(0, result.size());
    return result;
  }

  /// True if the peer has closed, and sent nothing more. False, and a failure, if it stays silent.
  bool ends() {
    const double begin = monotonic_now();
    const bool more = !got_.empty() || receive();
    EXPECT_LT(monotonic_now() - begin, 0.9 * kLong) << "it stays open";
    return !more;
  }

  Response response(bool has_body = true) {
    std::size_t end = 0;
    while ((end = got_.find("\r\n\r\n")) == std::string::npos) {
      if (!receive()) return {};
    }
    const std::string head = read(end + 4);
    Response result;
    std::size_t from = head.find("\r\n");
    result.line = head.substr(0, from);
    result.status = std::stoi(result.line.substr(result.line.find(' ')));
    for (from += 2; from < end;) {
      const std::size_t stop = head.find("\r\n", from), colon = head.find(": ", from);
      std::string name = head.substr(from, colon - from);
      std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
      EXPECT_TRUE(result.headers.emplace(name, head.substr(colon + 2, stop - colon - 2)).second)
          << name << " is there twice";
      from = stop + 2;
    }
    if (has_body && result.status != 304 && result.status != 101) {
      const std::size_t length = std::stoul("0" + result["content-length"]);
      result.body = read(length);
      EXPECT_EQ(result.body.size(), length);
    }
    return result;
  }

 private:
  explicit Connection(int socket) : socket_(socket) {
    timeval limit{static_cast<time_t>(kLong), 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
  }

  bool receive() {
    char buffer[65536];
    const ssize_t n = ::recv(socket_, buffer, sizeof buffer, 0);
    if (n > 0) got_.append(buffer, static_cast<std::size_t>(n));
    return n > 0;
  }

  int socket_;
  bool connected_ = false;
  std::string got_;
};

struct Frame {
  int opcode = -1;  ///< -1: none came
  std::string payload;
  int close_code() const {
    return opcode == 8 && payload.size() >= 2
               ? static_cast<unsigned char>(payload[0]) << 8 | static_cast<unsigned char>(payload[1])
               : 0;
  }
};

enum Opcode { kContinued = 0, kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10 };

/// As a client sends it (RFC 6455, 5.2).
std::string frame(int opcode, std::string payload, bool last = true) {
  std::string result;
  result += static_cast<char>((last ? 0x80 : 0) | opcode);
  const std::size_t n = payload.size();
  const auto length = [&](int mark, int count) {
    result += static_cast<char>(0x80 | mark);
    for (int k = count - 1; k >= 0; --k) result += static_cast<char>(n >> (8 * k) & 0xffU);
  };
  if (n < 126) {
    result += static_cast<char>(0x80U | n);
  } else if (n < 65536) {
    length(126, 2);
  } else {
    length(127, 8);
  }
  const std::string mask("\x12\x34\x56\x78");
  for (std::size_t k = 0; k < n; ++k) payload[k] = static_cast<char>(payload[k] ^ mask[k % 4]);
  return result + mask + payload;
}

Frame read_frame(Connection& connection) {
  const std::string head = connection.read(2);
  if (head.size() < 2) return {};
  EXPECT_EQ(head[0] & 0x70, 0);
  EXPECT_EQ(head[1] & 0x80, 0) << "a server does not mask";
  std::size_t length = head[1] & 0x7f;
  if (length >= 126) {
    std::size_t longer = 0;
    for (const char byte : connection.read(length == 126 ? 2 : 8))
      longer = longer << 8U | static_cast<unsigned char>(byte);
    length = longer;
  }
  return {head[0] & 0x0f, connection.read(length)};
}

class WebServerTest : public testing::Test {
 protected:
  WebServerTest() {
    add_rosapi(hub);
    for (std::size_t k = 0; k < 1000; ++k) file += static_cast<char>('a' + k % 26);
    big.resize(8 << 20);
    for (std::size_t k = 0; k < big.size(); ++k) big[k] = static_cast<char>(k * 2654435761U >> 24U);
  }
  ~WebServerTest() override {
    if (server) server->stop();
  }

  void start(const std::string& token = "") {
    WebServerOptions options;
    options.token = token;
    start(options);
  }

  void start(WebServerOptions options) {
    options.port = 0;
    server = std::make_unique<WebServer>(
        hub, [this](const std::string& path) { return page(path); }, options);
    server->start();
  }

  WebPage page(const std::string& path) const {
    WebPage result;
    result.tag = "v1";
    if (path == "/file") {
      result.type = "text/html";
      result.policy = "default-src 'self'";
      result.bytes = file;
    } else if (path == "//evil.example/file") {
      result.type = "text/html";
      result.bytes = file;
    } else if (path == "/big") {
      result.bytes = big;
    } else if (path == "/made") {  // lives as long as it is sent
      auto made = std::make_shared<const std::string>(big);
      result.bytes = *made;
      result.keeps = std::move(made);
    } else if (path != "/empty") {
      return text_page(path == "/" ? 200 : 404, "you asked for " + path);
    }
    return result;
  }

  std::string own_host() const { return "127.0.0.1:" + std::to_string(server->port()); }

  std::string request(const std::string& line, const std::string& more = "") const {
    return line + " HTTP/1.1\r\nHost: " + own_host() + "\r\n" + more + "\r\n";
  }

  Response ask(const std::string& line, const std::string& more = "") const {
    Connection connection(server->port());
    EXPECT_TRUE(connection.send(request(line, more)));
    return connection.response(!line.starts_with("HEAD"));
  }

  /// The handshake of RFC 6455, 1.3.
  std::string upgrade(const std::string& target = "/", const std::string& more = "") const {
    return request("GET " + target,
                   "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: "
                   "dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n" +
                       more);
  }

  std::unique_ptr<Connection> web_socket() const {
    auto connection = std::make_unique<Connection>(server->port());
    connection->send(upgrade());
    const Response response = connection->response();
    EXPECT_EQ(response.status, 101);
    EXPECT_EQ(response["sec-websocket-accept"], "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
    return connection;
  }

  static Json call(Connection& connection, const Json& message) {
    EXPECT_TRUE(connection.send(frame(kText, message.dump())));
    const Frame answer = read_frame(connection);
    EXPECT_EQ(answer.opcode, kText);
    return answer.opcode == kText ? Json::parse(answer.payload) : Json();
  }

  static bool answers(Connection& connection) {
    return call(connection, {{"op", "call_service"}, {"service", "/rosapi/nodes"}}).value("result", false);
  }

  /// What `value` gives on the server's thread.
  template <class Value>
  auto there(Value value) const {
    std::promise<decltype(value())> promise;
    server->post([&] { promise.set_value(value()); });
    return promise.get_future().get();
  }

  /// Waits for what need not be at once. False if it never is.
  template <class Condition>
  static bool in_time(Condition condition) {
    for (const double begin = monotonic_now(); monotonic_now() < begin + kLong;) {
      if (condition()) return true;
      sleep_until(monotonic_now() + 5e-3);
    }
    return false;
  }

  std::string file, big;
  Hub hub;
  Topic& topic = hub.add_topic("/a", "std_msgs/String");
  std::unique_ptr<WebServer> server;
};

TEST_F(WebServerTest, AnswersGetWithAPage) {
  start();
  const Response response = ask("GET /");
  EXPECT_EQ(response.line, "HTTP/1.1 200 OK");
  EXPECT_EQ(response.body, "you asked for /\n");
  EXPECT_EQ(response["content-type"], "text/plain; charset=utf-8");
  EXPECT_EQ(response["content-length"], "16");
  EXPECT_EQ(response["cache-control"], "no-store");
  EXPECT_EQ(response["etag"], "");
  EXPECT_EQ(response["set-cookie"], "");
  EXPECT_EQ(response["x-content-type-options"], "nosniff");
  EXPECT_EQ(response["x-frame-options"], "DENY");
  EXPECT_EQ(response["referrer-policy"], "no-referrer");
  EXPECT_EQ(response["cross-origin-resource-policy"], "same-origin");
  EXPECT_EQ(response["content-security-policy"], "default-src 'none'");
  EXPECT_EQ(response["access-control-allow-origin"], "") << "for its own pages alone";
}

TEST_F(WebServerTest, AsksItsSiteForTheDecodedPath) {
  start();
  EXPECT_EQ(ask("GET /a%20b?c=d").body, "you asked for /a b\n");
  EXPECT_EQ(ask("GET /nowhere").status, 404);
  for (const char* path : {"/../etc/passwd", "/%2e%2e/a", "/a%00", "/%zz", "*"})
    EXPECT_EQ(ask(std::string("GET ") + path).status, 400) << path;
}

TEST_F(WebServerTest, AnswersHeadWithTheHeadersOfGet) {
  start();
  for (const char* path : {"/", "/file", "/empty", "/big", "/nowhere"}) {
    Connection connection(server->port());
    connection.send(request(std::string("HEAD ") + path) + request("GET /"));
    const Response head = connection.response(false), get = ask(std::string("GET ") + path);
    EXPECT_EQ(head.line, get.line);
    EXPECT_EQ(head.headers, get.headers);
    EXPECT_EQ(connection.response().body, "you asked for /\n") << "nothing else was between them";
  }
}

/// Takes files at /up/NAME, up to a megabyte.
class WebUploadTest : public WebServerTest {
 protected:
  WebServerOptions taking(const std::string& token = "") {
    WebServerOptions options;
    options.token = token;
    options.uploads.folder = "/up/";
    options.uploads.place = [this](const std::string& path, std::uint64_t bytes) {
      EXPECT_THAT(path, testing::StartsWith("/up/"));
      if (bytes > 1 << 20) throw Error("too large");
      return (folder.folder() / std::to_string(++places)).string();
    };
    options.uploads.have = [this](const std::string& file) {
      have.push_back(bytes_of(file));
      if (have.back() == "bad") throw Error("it is bad");
      return text_page(200, "thanks");
    };
    options.uploads.drop = [this](const std::string& file) {
      std::filesystem::remove(file);
      ++dropped;
    };
    return options;
  }
  static std::string bytes_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
  Response put(const std::string& path, const std::string& body, const std::string& more = "") const {
    return ask("PUT " + path, more + "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  }

  test::TemporaryFile folder{"", "x"};
  std::vector<std::string> have;  ///< of the thread of pages
  std::atomic<int> places = 0, dropped = 0;
};

TEST_F(WebUploadTest, TakesAFileWholeAndSaysSo) {
  start(taking());
  std::string body(700'000, 'a');
  for (std::size_t i = 0; i < body.size(); ++i) body[i] = static_cast<char>(i * i % 251);
  const Response response = put("/up/x%20y", body);
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(response.body, "thanks\n");
  EXPECT_EQ(put("/up/none", "").status, 200);
  server->stop();
  EXPECT_THAT(have, testing::ElementsAre(body, ""));
  EXPECT_EQ(dropped, 0);
}

TEST_F(WebUploadTest, RefusesWithAReasonBeforeAnythingIsRead) {
  start(taking());
  EXPECT_EQ(put("/elsewhere", "a").status, 405);
  EXPECT_EQ(put("/up/a", std::string((1 << 20) + 1, 'a')).body, "too large\n");
  EXPECT_EQ(put("/up/a", "bad").body, "it is bad\n");
  EXPECT_EQ(ask("PUT /up/a", "Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n").status, 411);
  EXPECT_EQ(put("/up/a", "a", "Origin: http://elsewhere.example\r\n").status, 403);
  EXPECT_EQ(ask("GET /").status, 200) << "and goes on";
  server->stop();
  EXPECT_THAT(have, testing::ElementsAre("bad"));
  EXPECT_EQ(dropped, 1) << "the bad one";
}

// Else what is still to come of it would be taken for the next request.
TEST_F(WebUploadTest, EndsTheConnectionOfWhatIsRefused) {
  start(taking());
  for (const char* path : {"/elsewhere", "/up/a"}) {
    Connection connection(server->port());
    const std::string body = request("GET /");
    connection.send(request(std::string("PUT ") + path,
                            "Content-Length: " + std::to_string((2 << 20) + body.size()) + "\r\n") +
                    body);
    const Response refused = connection.response();
    EXPECT_GE(refused.status, 400);
    EXPECT_EQ(refused["connection"], "close");
    EXPECT_TRUE(connection.ends());
  }
}

TEST_F(WebUploadTest, TheAnswerReachesAPeerThatStillSends) {
  start(taking());
  Connection connection(server->port());
  const std::string body(16 << 20, 'a');
  EXPECT_TRUE(connection.send(
      request("PUT /elsewhere", "Content-Length: " + std::to_string(body.size()) + "\r\n") + body));
  EXPECT_EQ(connection.response().status, 405);
}

TEST_F(WebUploadTest, WantsTheToken) {
  start(taking("0123456789abcdef"));
  EXPECT_EQ(put("/up/a", "a").status, 401);
  EXPECT_EQ(put("/up/a", "a", "Authorization: Bearer 0123456789abcdef\r\n").status, 200);
}

TEST_F(WebUploadTest, LetsGoOfWhatBreaksOffAndTakesOneAtATime) {
  start(taking());
  {
    Connection first(server->port());
    first.send(request("PUT /up/a", "Content-Length: 1000\r\n") + "half of it");
    ASSERT_TRUE(in_time([&] { return places == 1; }));
    EXPECT_EQ(put("/up/b", "b").status, 503);
  }
  EXPECT_TRUE(in_time([&] { return dropped == 1; }));
  EXPECT_EQ(put("/up/b", "b").status, 200);
}

TEST_F(WebServerTest, AnswersNoOtherMethod) {
  start();
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH", "BREW"}) {
    const Response response = ask(std::string(method) + " /file", "Content-Length: 0\r\n");
    EXPECT_EQ(response.status, 405) << method;
    EXPECT_EQ(response["allow"], "GET, HEAD") << method;
  }
  const Response with_body = ask("POST /file", "Content-Length: 5\r\n\r\nhello");
  EXPECT_EQ(with_body.status, 405);
}

TEST_F(WebServerTest, TellsWhatAFileIs) {
  start();
  const Response response = ask("GET /file");
  EXPECT_EQ(response.body, file);
  EXPECT_EQ(response["content-type"], "text/html");
  EXPECT_EQ(response["etag"], "\"v1\"");
  EXPECT_EQ(response["cache-control"], "no-cache");
  EXPECT_EQ(response["accept-ranges"], "bytes");
  EXPECT_EQ(response["content-security-policy"], "default-src 'self'");
  const Response empty = ask("GET /empty");
  EXPECT_EQ(empty.status, 200);
  EXPECT_EQ(empty["content-length"], "0");
}

TEST_F(WebServerTest, SendsParts) {
  start();
  const Response middle = ask("GET /file", "Range: bytes=10-19\r\n");
  EXPECT_EQ(middle.line, "HTTP/1.1 206 Partial Content");
  EXPECT_EQ(middle["content-range"], "bytes 10-19/1000");
  EXPECT_EQ(middle["etag"], "\"v1\"");
  EXPECT_EQ(middle.body, file.substr(10, 10));
  EXPECT_EQ(ask("GET /file", "Range: bytes=990-\r\n").body, file.substr(990));
  EXPECT_EQ(ask("GET /file", "Range: bytes=-7\r\n").body, file.substr(993));
  const Response beyond = ask("GET /file", "Range: bytes=1000-\r\n");
  EXPECT_EQ(beyond.status, 416);
  EXPECT_EQ(beyond["content-range"], "bytes */1000");
  EXPECT_EQ(beyond.body, "");
  EXPECT_EQ(ask("GET /empty", "Range: bytes=0-\r\n").status, 416);
  for (const char* none : {"bytes=0-1,3-4", "lines=1-2", "bytes=2-1"}) {
    const Response whole = ask("GET /file", std::string("Range: ") + none + "\r\n");
    EXPECT_EQ(whole.status, 200) << none;
    EXPECT_EQ(whole.body, file) << none;
  }
  EXPECT_EQ(ask("GET /", "Range: bytes=0-1\r\n").status, 200) << "what is not kept has no parts";
}

TEST_F(WebServerTest, SendsPartsOfWhatTheClientHasAlready) {
  start();
  EXPECT_EQ(ask("GET /file", "Range: bytes=0-4\r\nIf-Range: \"v1\"\r\n").status, 206);
  for (const char* condition : {"\"v0\"", "W/\"v1\"", "Sat, 29 Oct 1994 19:43:31 GMT"}) {
    const Response whole =
        ask("GET /file", std::string("Range: bytes=0-4\r\nIf-Range: ") + condition + "\r\n");
    EXPECT_EQ(whole.status, 200) << condition;
    EXPECT_EQ(whole.body, file) << condition;
  }
}

// RFC 9110, 14.2: GET is the only method that Range is for; with another it must be ignored.
TEST_F(WebServerTest, HeadHasNoParts) {
  start();
  const Response head = ask("HEAD /file", "Range: bytes=0-4\r\n");
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head["content-length"], "1000");
}

TEST_F(WebServerTest, SendsNothingThatTheClientHas) {
  start();
  for (const char* tags : {"\"v1\"", "W/\"v1\"", "\"v0\", \"v1\"", "\"v1\",\"v2\""}) {
    for (const char* method : {"GET", "HEAD"}) {
      Connection connection(server->port());
      connection.send(
          request(std::string(method) + " /file", std::string("If-None-Match: ") + tags + "\r\n") +
          request("GET /"));
      const Response response = connection.response(false);
      EXPECT_EQ(response.line, "HTTP/1.1 304 Not Modified") << tags;
      EXPECT_EQ(response["etag"], "\"v1\"");
      EXPECT_EQ(response["content-length"], "");
      EXPECT_EQ(connection.response().body, "you asked for /\n") << "nothing else was between them";
    }
  }
  for (const char* tags : {"\"v0\"", "\"v11\"", "\"xv1\"", "v1"})
    EXPECT_EQ(ask("GET /file", std::string("If-None-Match: ") + tags + "\r\n").body, file) << tags;
  EXPECT_EQ(ask("GET /file", "If-None-Match: \"v1\"\r\nRange: bytes=0-1\r\n").status, 304);
  EXPECT_EQ(ask("GET /nowhere", "If-None-Match: \"v1\"\r\n").status, 404);
}

// RFC 9110, 13.1.2: "*" is any representation there is.
TEST_F(WebServerTest, SendsNothingToAClientThatHasAny) {
  start();
  EXPECT_EQ(ask("GET /file", "If-None-Match: *\r\n").status, 304);
}

TEST_F(WebServerTest, KeepsTheConnection) {
  start();
  Connection connection(server->port());
  for (int k = 0; k < 3; ++k) {
    connection.send(request("GET /" + std::to_string(k)));
    EXPECT_EQ(connection.response().body, "you asked for /" + std::to_string(k) + '\n');
  }
  connection.send(request("GET /x") + request("GET /y") + request("GET /z"));  // at once
  for (const char* body : {"you asked for /x\n", "you asked for /y\n", "you asked for /z\n"})
    EXPECT_EQ(connection.response().body, body);
}

TEST_F(WebServerTest, ClosesTheConnectionWhereThatIsAskedFor) {
  start();
  for (const std::string& text :
       {request("GET /", "Connection: close\r\n"), "GET / HTTP/1.0\r\nHost: " + own_host() + "\r\n\r\n"}) {
    Connection connection(server->port());
    connection.send(text);
    EXPECT_EQ(connection.response().status, 200);
    EXPECT_TRUE(connection.ends());
  }
}

TEST_F(WebServerTest, TakesARequestByteByByte) {
  start();
  Connection connection(server->port());
  for (const char byte : request("GET /")) ASSERT_TRUE(connection.send({&byte, 1}));
  EXPECT_EQ(connection.response().status, 200);
}

TEST_F(WebServerTest, SendsWhatIsLarge) {
  start();
  for (const char* path : {"/big", "/made"}) {
    const Response response = ask(std::string("GET ") + path);
    EXPECT_EQ(response.body.size(), big.size());
    EXPECT_TRUE(response.body == big) << path;
  }
}

TEST_F(WebServerTest, SurvivesClientsThatGoInTheMiddle) {
  start();
  for (int k = 0; k < 20; ++k) {
    Connection connection(server->port());
    connection.send(request("GET /made"));
    connection.read(1000);
  }
  EXPECT_EQ(ask("GET /").status, 200);
}

TEST_F(WebServerTest, RefusesARequestLineOfAMegabyte) {
  start();
  Connection connection(server->port());
  connection.send("GET /" + std::string(1 << 20, 'a') + " HTTP/1.1\r\n\r\n");
  const Response response = connection.response();  // none, or that it is too long
  EXPECT_TRUE(response.status == 0 || response.status == 414 || response.status == 431) << response.line;
  EXPECT_EQ(ask("GET /").status, 200);
}

TEST_F(WebServerTest, RefusesEndlessHeadersAndBodies) {
  start();
  for (const std::string& text :
       {"GET / HTTP/1.1\r\n" + std::string(1 << 20, 'a'),
        "GET / HTTP/1.1\r\nHost: " + own_host() + "\r\nA: " + std::string(1 << 20, 'a'),
        request("POST /", "Content-Length: 1000000000\r\n") + std::string(1 << 20, 'a'),
        request("POST /", "Transfer-Encoding: chunked\r\n") + "fffff\r\n" + std::string(1 << 20, 'a')}) {
    Connection connection(server->port());
    connection.send(text);
    const int status = connection.response().status;
    EXPECT_TRUE(status == 0 || status >= 400) << status;
  }
  EXPECT_EQ(ask("GET /").status, 200);
}

TEST_F(WebServerTest, ClosesOnWhatIsNotHttp) {
  start();
  for (const std::string& text :
       {std::string("\x16\x03\x01\x02\0\x01\0\x01\xfc\x03\x03\r\n\r\n", 16), std::string("hello\r\n\r\n"),
        std::string("GET / HTTP/9.9\r\n\r\n"), std::string(100, '\0'), std::string("GET /\r\n\r\n"),
        std::string("GET / HTTP/1.1\r\nno colon\r\n\r\n")}) {
    Connection connection(server->port());
    connection.send(text);
    const int status = connection.response().status;
    EXPECT_TRUE(status == 0 || status >= 400) << status << " of " << text;
  }
  EXPECT_EQ(ask("GET /").status, 200);
}

TEST_F(WebServerTest, WhoIsSilentLocksNobodyOut) {
  for (const char* token : {"", "s3cret"}) {
    start(token);
    const std::string mine = *token == '\0' ? "" : "Authorization: Bearer s3cret\r\n";
    const auto socket = std::make_unique<Connection>(server->port());
    socket->send(upgrade("/", mine));
    EXPECT_EQ(socket->response().status, 101);
    std::list<Connection> open;
    for (int k = 0; k < 400; ++k) {
      ASSERT_TRUE(open.emplace_back(server->port()).is_connected());
      if (k % 2 == 0) open.back().send("GET / HTT");  // and never more
    }
    for (int k = 0; k < 20; ++k) {
      EXPECT_EQ(ask("GET /", mine).status, 200);
      Connection late(server->port());
      late.send(upgrade("/", mine));
      EXPECT_EQ(late.response().status, 101);
      EXPECT_TRUE(answers(late));
    }
    EXPECT_TRUE(answers(*socket)) << "who was in stays in";
    EXPECT_TRUE(open.front().ends()) << "the oldest made room";
    server->stop();
  }
}

TEST_F(WebServerTest, WhoAsksAndThenKeepsStillLocksNobodyOut) {
  start();
  std::list<Connection> open;
  for (std::size_t k = 0; k < WebServer::kMostConnections + 20; ++k) {
    open.emplace_back(server->port()).send(request("GET /"));
    EXPECT_EQ(open.back().response().status, 200);
  }
  EXPECT_TRUE(open.front().ends()) << "who has been silent for longest made room";
  open.back().send(request("GET /"));
  EXPECT_EQ(open.back().response().status, 200);
}

TEST_F(WebServerTest, WithoutTheTokenThereIsLittleTime) {
  start("s3cret");
  const double begin = monotonic_now();
  Connection silent(server->port()), refused(server->port());
  for (int k = 0; k < 3; ++k) {  // it may go on asking, but not for ever
    refused.send(request("GET /"));
    EXPECT_EQ(refused.response().status, 401);
  }
  EXPECT_TRUE(silent.ends());
  EXPECT_TRUE(refused.ends());
  EXPECT_GE(monotonic_now() - begin, 0.8 * WebServer::kStrangerTime);
  EXPECT_LE(monotonic_now() - begin, 20.0) << "and not the half minute that others have";
}

TEST_F(WebServerTest, APageThatTakesLongKeepsNoSocketWaiting) {
  std::promise<void> asked, may_go;
  WebServerOptions options;
  options.port = 0;
  server = std::make_unique<WebServer>(
      hub,
      [&](const std::string& path) {
        if (path == "/slow") {
          asked.set_value();
          may_go.get_future().wait();
        }
        return text_page(200, path);
      },
      options);
  server->start();
  const auto socket = web_socket();
  Connection slow(server->port());
  slow.send(request("GET /slow"));
  asked.get_future().wait();
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(answers(*socket)) << "while the page waits";
  may_go.set_value();
  EXPECT_EQ(slow.response().body, "/slow\n");
}

TEST_F(WebServerTest, ASlowServiceKeepsNobodyWaiting) {
  std::promise<void> may_go;
  std::shared_future<void> let_go = may_go.get_future().share();
  std::atomic<int> done = 0;
  hub.add_slow_service("/slow", "std_srvs/Trigger", [&](const Json&, const Reply& reply) {
    server->elsewhere([=] { let_go.wait(); },
                      [&done, reply] {
                        reply.give({{"late", true}});
                        ++done;
                      });
  });
  start();
  const auto socket = web_socket();
  auto gone = web_socket();
  const Json slow{{"op", "call_service"}, {"service", "/slow"}, {"id", "7"}};
  gone->send(frame(kText, slow.dump()));
  socket->send(frame(kText, slow.dump()));
  for (int k = 0; k < 3; ++k) {
    const Json answer = call(*socket, {{"op", "call_service"}, {"service", "/rosapi/nodes"}});
    EXPECT_EQ(answer["service"], "/rosapi/nodes") << "before the slow one";
  }
  EXPECT_EQ(ask("GET /").status, 200);
  gone.reset();
  EXPECT_TRUE(in_time([&] { return hub.client_count() == 1; }));
  EXPECT_EQ(done, 0);
  may_go.set_value();
  const Frame late = read_frame(*socket);
  EXPECT_EQ(Json::parse(late.payload), (Json{{"op", "service_response"},
                                             {"service", "/slow"},
                                             {"id", "7"},
                                             {"result", true},
                                             {"values", {{"late", true}}}}));
  EXPECT_TRUE(in_time([&] { return done == 2; })) << "the answer to who is gone is lost, and nothing else";
}

TEST_F(WebServerTest, SendsAFileThatIsReadAsItGoes) {
  const test::TemporaryFile on_disk(big);
  auto opened = std::make_shared<const InputFile>(on_disk.path());
  WebServerOptions options;
  options.port = 0;
  server = std::make_unique<WebServer>(
      hub,
      [&](const std::string&) {
        WebPage page;
        page.tag = "v1";
        page.file = opened;
        return page;
      },
      options);
  server->start();
  EXPECT_TRUE(ask("GET /").body == big);
  EXPECT_EQ(ask("GET /", "Range: bytes=1000000-1000009\r\n").body, big.substr(1000000, 10));
  EXPECT_EQ(ask("HEAD /")["content-length"], std::to_string(big.size()));
  EXPECT_EQ(ask("GET /", "If-None-Match: \"v1\"\r\n").status, 304);

  // Cut in place: what is there is sent, the connection ends, and all else goes on.
  std::filesystem::resize_file(on_disk.path(), 1000);
  Connection cut(server->port());
  cut.send(request("GET /"));
  EXPECT_LT(cut.read(big.size()).size(), big.size());
  EXPECT_EQ(ask("GET /", "Range: bytes=10-19\r\n").body, big.substr(10, 10));
}

TEST_F(WebServerTest, RefusesOtherHostsAndOrigins) {
  start();
  Connection connection(server->port());
  connection.send("GET / HTTP/1.1\r\nHost: evil.example:" + std::to_string(server->port()) + "\r\n\r\n");
  const Response response = connection.response();
  EXPECT_EQ(response.status, 403);
  EXPECT_THAT(response.body, HasSubstr(std::to_string(server->port())));
  connection.send("GET / HTTP/1.1\r\n\r\n");
  EXPECT_EQ(connection.response().status, 403) << "no Host";
  EXPECT_EQ(ask("GET /", "Origin: http://evil.example\r\n").status, 403);
  EXPECT_EQ(ask("GET /", "Origin: null\r\n").status, 403);
  EXPECT_EQ(ask("GET /", "Origin: http://" + own_host() + "\r\n").status, 200);
  Connection socket(server->port());
  socket.send(upgrade("/", "Origin: http://evil.example\r\n"));
  EXPECT_EQ(socket.response().status, 403);
  EXPECT_EQ(hub.client_count(), 0U);
}

TEST_F(WebServerTest, WantsItsTokenOnceAndThenTheCookie) {
  start("s3cret");
  EXPECT_THAT(server->url(), AllOf(HasSubstr("http://127.0.0.1:"), HasSubstr("/?token=s3cret")));
  const Response refused = ask("GET /big");
  EXPECT_EQ(refused.status, 401);
  EXPECT_EQ(refused["www-authenticate"], "Bearer");
  EXPECT_THAT(refused.body, Not(HasSubstr("s3cret")));
  EXPECT_EQ(refused["set-cookie"], "");
  EXPECT_EQ(ask("GET /big?token=wrong")["set-cookie"], "");
  const Response taken = ask("GET /big?token=s3cret");
  EXPECT_EQ(taken.status, 200) << "whoever loads something is not sent elsewhere";
  EXPECT_TRUE(taken.body == big);
  const std::string set = taken["set-cookie"];
  EXPECT_THAT(set, AllOf(HasSubstr("palpate-" + std::to_string(server->port()) + '='), HasSubstr("HttpOnly"),
                         HasSubstr("SameSite=Lax"), Not(HasSubstr("s3cret"))));
  EXPECT_EQ(ask("GET /file", "Cookie: a=b; " + set.substr(0, set.find(';')) + "\r\n").body, file);
  EXPECT_EQ(ask("GET /file", "Authorization: Bearer s3cret\r\n").body, file);
  EXPECT_EQ(ask("GET /file", "Authorization: Bearer s3cret\r\n")["set-cookie"], "");
  Connection again(server->port());
  again.send(request("GET /file?token=s3cret", ""));
  EXPECT_NE(again.response()["set-cookie"], "");
  again.send(request("GET /file"));
  const Response later = again.response();
  EXPECT_EQ(later.status, 401);
  EXPECT_EQ(later["set-cookie"], "") << "that request has not brought the token";
  Connection without(server->port());
  without.send(upgrade());
  EXPECT_EQ(without.response().status, 401);
  Connection with(server->port());
  with.send(upgrade("/?token=s3cret"));
  EXPECT_EQ(with.response().status, 101);
  EXPECT_TRUE(answers(with));
}

TEST_F(WebServerTest, TheTokenLeavesTheAddressOfAPage) {
  start("s3cret");
  for (const char* method : {"GET", "HEAD"}) {
    const Response moved = ask(std::string(method) + " /file?view=top&token=s3cret&x=%26");
    EXPECT_EQ(moved.line, "HTTP/1.1 303 See Other");
    EXPECT_EQ(moved["location"], "/file?view=top&x=%26");
    EXPECT_NE(moved["set-cookie"], "");
    EXPECT_THAT(moved.body, Not(HasSubstr("s3cret")));
  }
  const std::string set = ask("GET /file?token=s3cret")["set-cookie"];
  const std::string cookie = "Cookie: " + set.substr(0, set.find(';')) + "\r\n";
  EXPECT_EQ(ask("GET /file", cookie).body, file);
  EXPECT_EQ(ask("GET /file?token=wrong", cookie).status, 200) << "a token that is none can stay";
  const Response other = ask("GET //evil.example/file?token=s3cret");
  EXPECT_EQ(other["location"], "") << "which would be at another host";
}

TEST_F(WebServerTest, TakesNoTokenAfterTooManyWrongOnes) {
  start("s3cret");
  Connection in(server->port());
  in.send(request("GET /big?token=s3cret", "Range: bytes=0-1\r\n"));
  const std::string set = in.response()["set-cookie"];
  int wrong = 0;
  while (ask("GET /?token=wrong").status == 401) ASSERT_LT(++wrong, 100);
  EXPECT_GE(wrong, 5);
  const Response right = ask("GET /?token=s3cret");
  EXPECT_EQ(right.status, 429);
  EXPECT_EQ(right["set-cookie"], "");
  Connection socket(server->port());
  socket.send(upgrade("/?token=s3cret"));
  EXPECT_EQ(socket.response().status, 429);
  in.send(request("GET /?token=s3cret"));
  EXPECT_EQ(in.response().status, 200) << "who was in before is in";
  Connection by_cookie(server->port());
  by_cookie.send(upgrade("/", "Cookie: " + set.substr(0, set.find(';')) + "\r\n"));
  EXPECT_EQ(by_cookie.response().status, 101);
}

TEST_F(WebServerTest, CountsWrongTokensByTheAddressTheyComeFrom) {
  start("s3cret");
  while (ask("GET /?token=wrong").status == 401) continue;
  const std::string right = request("GET /", "Authorization: Bearer s3cret\r\n");
  Connection same(server->port()), other(server->port(), "127.0.0.2");
  same.send(right);
  other.send(right);
  EXPECT_EQ(same.response().status, 429);
  EXPECT_EQ(other.response().status, 200);
}

TEST_F(WebServerTest, ListensOnIpv6) {
  WebServerOptions options;
  options.address = "::1";
  options.token = "s3cret";
  try {
    start(options);
  } catch (const Error&) {
    GTEST_SKIP() << "this machine has no IPv6";
  }
  const std::string host = "[::1]:" + std::to_string(server->port());
  EXPECT_EQ(server->url(), "http://" + host + "/?token=s3cret");
  const auto ask_with = [&](const std::string& token) {
    const auto connection = Connection::of_ipv6(server->port());
    EXPECT_TRUE(connection->is_connected());
    connection->send("GET / HTTP/1.1\r\nHost: " + host + "\r\nAuthorization: Bearer " + token + "\r\n\r\n");
    return connection->response().status;
  };
  EXPECT_EQ(ask_with("s3cret"), 200);
  int wrong = 0;
  while (ask_with("wrong") == 401) ASSERT_LT(++wrong, 100);
  EXPECT_EQ(wrong, 5);
  EXPECT_EQ(ask_with("s3cret"), 429);
}

TEST_F(WebServerTest, SpeaksRosbridgeOverAWebSocket) {
  start();
  const auto socket = web_socket();
  const Json answer = call(*socket, {{"op", "call_service"}, {"service", "/rosapi/topics"}, {"id", "1"}});
  EXPECT_EQ(answer, (Json{{"op", "service_response"},
                          {"service", "/rosapi/topics"},
                          {"id", "1"},
                          {"result", true},
                          {"values", {{"topics", {"/a"}}, {"types", {"std_msgs/String"}}}}}));
  EXPECT_EQ(call(*socket, "nonsense")["op"], "status");
  EXPECT_EQ(there([&] { return hub.client_count(); }), 1U);
}

// Nothing may keep an emergency stop from being heard.
TEST_F(WebServerTest, AFrameThatRunsOutOfMemoryEndsItsOwnConnectionOnly) {
  hub.add_input("/starve", "std_msgs/String", [](const Json&, Client&) {
    test::fail_allocations(1);  // the next: that of closing the connection
    throw std::bad_alloc();
  });
  start();
  const auto starved = web_socket(), other = web_socket(), late = web_socket();
  starved->send(frame(kText, R"({"op": "publish", "topic": "/starve", "msg": {}})"));
  EXPECT_TRUE(answers(*other));
  EXPECT_TRUE(answers(*late));
  EXPECT_TRUE(starved->ends());
}

TEST_F(WebServerTest, TakesMessagesInPiecesAndInCbor) {
  start();
  const auto socket = web_socket();
  const std::string text = Json{{"op", "call_service"}, {"service", "/rosapi/nodes"}, {"id", "1"}}.dump();
  socket->send(frame(kText, text.substr(0, 10), false) + frame(kPing, "are you there") +
               frame(kContinued, text.substr(10)));
  const Frame pong = read_frame(*socket);
  EXPECT_EQ(pong.opcode, kPong);
  EXPECT_EQ(pong.payload, "are you there");
  EXPECT_EQ(Json::parse(read_frame(*socket).payload)["id"], "1");
  const std::vector<std::uint8_t> cbor = Json::to_cbor(Json::parse(text));
  socket->send(frame(kBinary, {cbor.begin(), cbor.end()}));
  EXPECT_EQ(Json::parse(read_frame(*socket).payload)["id"], "1");
}

TEST_F(WebServerTest, PublishesToThoseThatSubscribe) {
  start();
  const auto text = web_socket(), binary = web_socket(), none = web_socket();
  text->send(frame(kText, R"({"op": "subscribe", "topic": "/a"})"));
  binary->send(frame(kText, R"({"op": "subscribe", "topic": "/a", "compression": "cbor"})"));
  for (Connection* socket : {text.get(), binary.get(), none.get()})
    EXPECT_TRUE(answers(*socket));  // what came before was heard
  there([&] {
    topic.publish({{"data", "x"}});
    return 0;
  });
  const Json wanted{{"op", "publish"}, {"topic", "/a"}, {"msg", {{"data", "x"}}}};
  const Frame as_text = read_frame(*text), as_binary = read_frame(*binary);
  EXPECT_EQ(as_text.opcode, kText);
  EXPECT_EQ(Json::parse(as_text.payload), wanted);
  EXPECT_EQ(as_binary.opcode, kBinary);
  EXPECT_EQ(Json::from_cbor(as_binary.payload), wanted);
  EXPECT_TRUE(answers(*none)) << "and nothing before that";
}

TEST_F(WebServerTest, TellsWhenAClientHasNothingMoreToTake) {
  std::atomic<int> taken = 0, known = 0;
  hub.add_input("/in", "std_msgs/String", [&](const Json&, Client&) { ++taken; });
  hub.on_caught_up.emplace_back([&](Client&) { known = taken.load(); });
  start();
  const auto socket = web_socket();
  const std::string one = frame(kText, R"({"op": "publish", "topic": "/in", "msg": {"data": "x"}})");
  socket->send(one);
  EXPECT_TRUE(in_time([&] { return known == 1; }));
  std::string many;
  for (int k = 0; k < 20; ++k) many += one;
  socket->send(many);
  EXPECT_TRUE(in_time([&] { return known == 21; }));
  server->stop();
}

// Two messages at once are held back until both are there, and not a fifth of a second, as long as the system
// would hold them: a hundred times, that is twenty.
TEST_F(WebServerTest, HoldsNothingBackForLong) {
  start();
  const auto socket = web_socket();
  socket->send(frame(kText, R"({"op": "subscribe", "topic": "/a", "queue_length": 2})"));
  EXPECT_TRUE(answers(*socket));
  const double begin = monotonic_now();
  for (int k = 0; k < 100; ++k) {
    there([&] {
      for (int message = 0; message < 2; ++message) topic.publish({{"data", "x"}});
      return 0;
    });
    for (int message = 0; message < 2; ++message) ASSERT_EQ(read_frame(*socket).opcode, kText);
  }
  EXPECT_LT(monotonic_now() - begin, 15.0);
}

TEST_F(WebServerTest, AClientThatDoesNotReadGetsTheNewest) {
  start();
  const auto socket = web_socket();
  socket->send(frame(kText, R"({"op": "subscribe", "topic": "/a"})"));
  EXPECT_TRUE(answers(*socket));
  constexpr int kCount = 200;  // of 256 KiB: more than sockets keep
  for (int k = 1; k <= kCount; ++k) {
    there([&] {
      topic.publish({{"k", k}, {"data", std::string(1 << 18, 'x')}});
      return 0;
    });
  }
  int last = 0, came = 0;
  while (last < kCount) {
    const Frame got = read_frame(*socket);
    ASSERT_EQ(got.opcode, kText);
    const int k = Json::parse(got.payload)["msg"]["k"];
    EXPECT_GT(k, last);
    last = k;
    ++came;
  }
  EXPECT_LT(came, kCount);
}

TEST_F(WebServerTest, ClosesOnAMessageThatIsTooLong) {
  start();
  const std::string open = R"({"op": "unknown", "x": ")", end = R"("})";
  const auto message = [&](std::size_t bytes) {
    return open + std::string(bytes - open.size() - end.size(), 'x') + end;
  };
  auto socket = web_socket();
  socket->send(frame(kText, message(WebServer::kMostMessage)));
  EXPECT_THAT(read_frame(*socket).payload, HasSubstr("op 'unknown'")) << "just what it takes";
  socket->send(frame(kText, message(WebServer::kMostMessage + 1)));
  const Frame last = read_frame(*socket);
  EXPECT_TRUE(last.opcode == -1 || last.close_code() == 1009) << last.opcode;
  socket.reset();
  EXPECT_TRUE(in_time([&] { return there([&] { return hub.client_count(); }) == 0; }));

  // In pieces, each of which is short enough; and what only says that it is long.
  const auto pieces = web_socket();
  pieces->send(frame(kText, std::string(WebServer::kMostMessage / 2, ' '), false));
  pieces->send(frame(kContinued, std::string(WebServer::kMostMessage / 2, ' '), false));
  pieces->send(frame(kContinued, "  "));
  const Frame of_pieces = read_frame(*pieces);
  EXPECT_TRUE(of_pieces.opcode == -1 || of_pieces.close_code() == 1009) << of_pieces.opcode;
  const auto boast = web_socket();
  boast->send(std::string("\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff\x01\x02\x03\x04", 14));
  const Frame of_boast = read_frame(*boast);
  EXPECT_TRUE(of_boast.opcode == -1 || of_boast.close_code() != 0) << of_boast.opcode;
}

TEST_F(WebServerTest, ClosesOnTooManyMessagesASecondAndSaysSo) {
  start();
  auto socket = web_socket();
  const std::string one = frame(kText, R"({"op": "unadvertise"})");
  std::string many;
  for (int k = 0; k < 60'000; ++k) many += one;
  socket->send(many);
  const Frame goodbye = read_frame(*socket);
  EXPECT_EQ(goodbye.close_code(), 1008);
  EXPECT_THAT(goodbye.payload, HasSubstr("5000 messages a second"));
  socket.reset();  // else the server waits for the answer to its goodbye, but not for ever
  EXPECT_TRUE(in_time([&] { return there([&] { return hub.client_count(); }) == 0; }));
}

TEST_F(WebServerTest, ClosesOnFramesThatAreNone) {
  start();
  for (const std::string& bytes :
       {std::string("\x81\x02hi", 4),                // not masked
        std::string("\x83\x80\x01\x02\x03\x04", 6),  // of an unknown kind
        std::string("\xf1\x80\x01\x02\x03\x04", 6),  // reserved bits
        frame(kContinued, "x"), frame(kPing, std::string(126, 'x')), frame(kText, "\xff\xfe")}) {  // no UTF-8
    const auto socket = web_socket();
    socket->send(bytes);
    const Frame last = read_frame(*socket);
    EXPECT_TRUE(last.opcode == -1 || last.opcode == kClose) << last.opcode;
  }
  EXPECT_TRUE(answers(*web_socket()));
}

TEST_F(WebServerTest, AnswersGoodbyeWithGoodbye) {
  start();
  auto socket = web_socket();
  socket->send(frame(kClose, "\x03\xe8"));
  EXPECT_EQ(read_frame(*socket).close_code(), 1000);
  EXPECT_TRUE(socket->ends());
  socket.reset();
  EXPECT_TRUE(in_time([&] { return there([&] { return hub.client_count(); }) == 0; }));
}

TEST_F(WebServerTest, AHandshakeThatIsNoneIsRefused) {
  start();
  const std::string head = "Upgrade: websocket\r\nConnection: Upgrade\r\n";
  for (const std::string& more :
       {head + "Sec-WebSocket-Version: 13\r\n",
        head + "Sec-WebSocket-Version: 8\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"}) {
    const int status = ask("GET /nowhere", more).status;
    EXPECT_TRUE(status == 0 || status >= 400) << status << ' ' << more;
  }
  EXPECT_TRUE(in_time([&] { return there([&] { return hub.client_count(); }) == 0; }));
}

TEST_F(WebServerTest, TakesSoManyWebSocketsAndNoMore) {
  start();
  std::vector<std::unique_ptr<Connection>> sockets;
  for (std::size_t k = 0; k < WebServer::kMostClients; ++k) sockets.push_back(web_socket());
  EXPECT_EQ(there([&] { return hub.client_count(); }), WebServer::kMostClients);
  Connection surplus(server->port());
  surplus.send(upgrade());
  EXPECT_EQ(surplus.response().status, 503);
  EXPECT_EQ(ask("GET /").status, 200) << "pages are there for all that";
  EXPECT_TRUE(answers(*sockets.front()));
  sockets.pop_back();
  EXPECT_TRUE(in_time([&] {
    Connection next(server->port());
    next.send(upgrade());
    return next.response().status == 101;
  }));
}

TEST_F(WebServerTest, StopsWhileClientsAreConnected) {
  start();
  const auto socket = web_socket(), subscribed = web_socket();
  subscribed->send(frame(kText, R"({"op": "subscribe", "topic": "/a"})"));
  EXPECT_TRUE(answers(*subscribed));
  Connection silent(server->port()), half(server->port()), kept(server->port()), loading(server->port());
  half.send("GET / HT");
  kept.send(request("GET /"));
  EXPECT_EQ(kept.response().status, 200);
  loading.send(request("GET /big"));
  loading.read(1000);
  const std::uint16_t port = server->port();
  const double begin = monotonic_now();
  server->stop();
  EXPECT_LE(monotonic_now() - begin, 10.0) << "nobody's time need run out";
  EXPECT_EQ(hub.client_count(), 0U);
  EXPECT_FALSE(topic.is_watched());
  for (Connection* connection : {socket.get(), &half, &kept}) EXPECT_TRUE(connection->ends());
  EXPECT_FALSE(Connection(port).is_connected());
  server->stop();  // once more does no harm
  server.reset();
}

TEST_F(WebServerTest, NeedNotBeStarted) {
  WebServerOptions options;
  options.port = 0;
  WebServer idle(
      hub, [](const std::string&) { return text_page(200, ""); }, options);
  EXPECT_NE(idle.port(), 0);
}

TEST_F(WebServerTest, WorksAtARateAndWhenItIsWoken) {
  WebServerOptions options;
  options.port = 0;
  Wake wake;
  std::atomic<int> beats = 0, wakes = 0;
  server = std::make_unique<WebServer>(
      hub, [](const std::string&) { return text_page(200, ""); }, options);
  server->every(200.0, [&] { ++beats; });
  server->when(wake, [&] {
    wake.clear();
    ++wakes;
  });
  const double begin = monotonic_now();
  server->start();
  EXPECT_TRUE(in_time([&] { return beats >= 20; }));
  EXPECT_GE(monotonic_now() - begin, 19.0 / 200.0) << "and no faster";
  EXPECT_EQ(wakes, 0);
  for (int k = 1; k <= 3; ++k) {
    wake.set();
    EXPECT_TRUE(in_time([&] { return wakes == k; }));
  }
  server->stop();
  wake.set();  // its descriptor is still its own
  wake.clear();
}

// 50 beats are missed while one takes long, and not made up for: the next ten take as long as ten.
TEST_F(WebServerTest, DoesNotMakeUpForWhatItMissed) {
  constexpr double kRate = 200.0;
  WebServerOptions options;
  options.port = 0;
  std::vector<double> beats;  // on the server's thread
  std::atomic<bool> done = false;
  server = std::make_unique<WebServer>(
      hub, [](const std::string&) { return text_page(200, ""); }, options);
  server->every(kRate, [&] {
    if (beats.empty()) sleep_until(monotonic_now() + 50.0 / kRate);
    if (!done) beats.push_back(monotonic_now());
    done = beats.size() == 13;
  });
  server->start();
  EXPECT_TRUE(in_time([&] { return done.load(); }));
  server->stop();
  ASSERT_EQ(beats.size(), 13U);
  EXPECT_GE(beats[12] - beats[1], 10.0 / kRate);
}

// What it needed for that is gone by the time that it is told.
TEST_F(WebServerTest, ForgetsSlowWorkOnceThatIsDone) {
  start();
  for (int k = 0; k < 200; ++k) {
    auto needed = std::make_shared<int>(k);
    const std::weak_ptr<int> seen = needed;
    std::promise<bool> gone;
    server->elsewhere([needed = std::move(needed)] { EXPECT_GE(*needed, 0); },
                      [&] { gone.set_value(seen.expired()); });
    ASSERT_TRUE(gone.get_future().get()) << k;
  }
}

TEST_F(WebServerTest, SaysWhereItCannotListen) {
  start();
  WebServerOptions options;
  options.port = server->port();
  const auto listen = [&] {
    WebServer(
        hub, [](const std::string&) { return text_page(200, ""); }, options);
  };
  EXPECT_THAT(message_of<Error>(listen),
              AllOf(HasSubstr("127.0.0.1 port " + std::to_string(options.port)), HasSubstr("--port")));
  options.port = 0;
  for (const char* address : {"", "localhost", "256.0.0.1", "evil"}) {
    options.address = address;
    EXPECT_THAT(message_of<Error>(listen), HasSubstr("is not an IP address")) << address;
  }
  options.address = "192.0.2.1";  // of nobody (RFC 5737)
  for (const std::uint16_t port : {std::uint16_t{0}, std::uint16_t{9090}}) {
    options.port = port;
    EXPECT_THAT(message_of<Error>(listen), AllOf(HasSubstr("cannot listen on 192.0.2.1: this machine has no"),
                                                 HasSubstr("--listen"), Not(HasSubstr("port"))));
  }
}

// What has been sent is let go of while its reader stays.
TEST_F(WebServerTest, KeepsNoPageThatHasBeenSent) {
  std::weak_ptr<const std::string> sent;
  WebServerOptions options;
  options.port = 0;
  server = std::make_unique<WebServer>(
      hub,
      [&](const std::string&) {
        auto made = std::make_shared<const std::string>(file);
        sent = made;
        WebPage page;
        page.bytes = *made;
        page.keeps = std::move(made);
        return page;
      },
      options);
  server->start();
  Connection stays(server->port());
  stays.send(request("GET /"));
  EXPECT_EQ(stays.response().body, file);
  EXPECT_TRUE(in_time([&] { return sent.expired(); }));
  stays.send(request("GET /"));
  EXPECT_EQ(stays.response().body, file);
}

// A server that ends leaves its sides of connections waiting: its port can be had again at once all the same.
TEST_F(WebServerTest, ListensWhereAnotherHasJustEnded) {
  start();
  WebServerOptions options;
  options.port = server->port();
  const auto socket = web_socket();
  EXPECT_TRUE(answers(*socket));
  server->stop();
  server.reset();
  EXPECT_NO_THROW(WebServer(
      hub, [](const std::string&) { return text_page(200, ""); }, options));
}

TEST_F(WebServerTest, OnEveryAddressItIsCalledByItsHostName) {
  WebServerOptions options;
  options.address = "0.0.0.0";
  start(options);
  std::array<char, 256> name{};
  ASSERT_EQ(::gethostname(name.data(), name.size()), 0);
  EXPECT_EQ(server->url(), "http://" + std::string(name.data()) + ":" + std::to_string(server->port()) + "/");
}

TEST(OwnAddress, IsOneOfAnInterfaceForOthers) {
  EXPECT_TRUE(is_any_address("0.0.0.0") && is_any_address("::"));
  EXPECT_FALSE(is_any_address("127.0.0.1") || is_any_address("::1") || is_any_address(""));
  const std::string own = own_address();
  if (own.empty()) GTEST_SKIP() << "no network";
  EXPECT_THAT(own, Not(testing::StartsWith("127.")));
  // One can listen only on addresses that the machine has.
  Hub hub;
  WebServerOptions options;
  options.address = own;
  options.port = 0;
  EXPECT_NO_THROW(WebServer(
      hub, [](const std::string&) { return text_page(200, ""); }, options));
}

TEST_F(WebServerTest, TellsOnceOfAPageOfAnotherOrigin) {
  std::mutex mutex;
  std::vector<std::string> told;
  WebServerOptions options;
  options.tell = [&](const std::string& line) {
    const std::scoped_lock lock(mutex);
    told.push_back(line);
  };
  start(options);
  EXPECT_EQ(ask("GET /", "Origin: http://" + own_host() + "\r\n").status, 200);
  EXPECT_EQ(ask("GET /", "Origin: http://localhost:5173\r\n").status, 403);
  EXPECT_EQ(ask("GET /", "Origin: http://localhost:5173\r\n").status, 403);
  Connection socket(server->port());
  socket.send(upgrade("/", "Origin: http://localhost:8000\r\n"));
  EXPECT_EQ(socket.response().status, 403);
  server->stop();
  EXPECT_THAT(told,
              testing::ElementsAre(HasSubstr("http://localhost:5173"), HasSubstr("http://localhost:8000")));
}

TEST_F(WebServerTest, ServersOfPortZeroAreApart) {
  start();
  const std::uint16_t first = server->port();
  EXPECT_EQ(server->url(), "http://127.0.0.1:" + std::to_string(first) + "/");
  WebServerOptions options;
  options.port = 0;
  const WebServer second(
      hub, [](const std::string&) { return text_page(200, ""); }, options);
  EXPECT_NE(second.port(), first);
  EXPECT_NE(first, 0);
}

}  // namespace
}  // namespace palpate

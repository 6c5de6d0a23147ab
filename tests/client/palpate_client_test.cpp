// The reference client against a scripted server that may be as bad as one likes, and against the program.
#include <client/palpate_client.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <support/allocation_guard.h>
#include <support/temporary_file.h>

extern char** environ;

namespace palpate_client {
namespace {

using nlohmann::json;
using testing::HasSubstr;
namespace net = boost::asio;
namespace websocket = boost::beast::websocket;

constexpr double kPatience = 30.0;        // s; longer than anything takes on a machine that does much else
constexpr double kDeviceForceMax = 12.0;  // N

void sleep(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

bool eventually(const std::function<bool()>& holds) {
  for (const double end = Client::now() + kPatience; Client::now() < end; sleep(1e-3)) {
    if (holds()) return true;
  }
  return false;
}

std::string wrench_text(double force, double stamp = Client::now()) {
  return messages::publish(
      messages::kWrench,
      {{"header", {{"stamp", messages::stamp(stamp)}, {"frame_id", "device"}}},
       {"wrench",
        {{"force", {{"x", 0}, {"y", 0}, {"z", force}}}, {"torque", {{"x", 0}, {"y", 0}, {"z", 0}}}}}});
}

/// Accepts one connection after the other, and keeps what is said on them.
class FakeServer {
 public:
  explicit FakeServer(int receive_buffer = 0) : acceptor_(context_, {net::ip::address_v4::loopback(), 0}) {
    if (receive_buffer > 0) acceptor_.set_option(net::socket_base::receive_buffer_size(receive_buffer));
    accept();
    thread_ = std::thread([this] { context_.run(); });
  }
  ~FakeServer() {
    context_.stop();
    thread_.join();
  }

  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }
  /// Sends a text, of whatever kind.
  void say(std::string text) {
    net::post(context_, [this, text = std::move(text)] {
      boost::system::error_code error;
      if (socket_) socket_->write(net::buffer(text), error);
    });
  }
  /// Ends the connection without a word.
  void drop() {
    net::post(context_, [this] { socket_->next_layer().close(); });
  }
  /// What has been heard, in order.
  std::vector<json> heard() const {
    const std::lock_guard lock(mutex_);
    return heard_;
  }
  std::vector<json> heard(const char* topic) const {
    std::vector<json> found;
    for (const json& message : heard()) {
      if (message.value("topic", "") == topic && message["op"] == "publish") found.push_back(message["msg"]);
    }
    return found;
  }
  std::string authorization() const {
    const std::lock_guard lock(mutex_);
    return authorization_;
  }
  std::atomic<bool> reads = true;
  std::atomic<bool> refuses = false;

 private:
  using Tcp = net::ip::tcp;

  void accept() {
    acceptor_.async_accept([this](boost::system::error_code error, Tcp::socket peer) {
      if (error) return;
      serve(std::move(peer));
      accept();
    });
  }

  void serve(Tcp::socket peer) {
    namespace http = boost::beast::http;
    boost::beast::flat_buffer buffer;
    http::request<http::empty_body> request;
    http::read(peer, buffer, request);
    {
      const std::lock_guard lock(mutex_);
      authorization_ = std::string(request[http::field::authorization]);
    }
    if (refuses) {
      http::response<http::empty_body> response(http::status::unauthorized, 11);
      response.prepare_payload();
      http::write(peer, response);
      return;
    }
    socket_.emplace(std::move(peer));
    received_.clear();
    socket_->accept(request);
    read();
  }

  void read() {
    if (!reads) {
      timer_.expires_after(std::chrono::milliseconds(5));
      return timer_.async_wait([this](boost::system::error_code) { read(); });
    }
    socket_->async_read(received_, [this](boost::system::error_code error, std::size_t) {
      if (error) return;
      {
        const std::lock_guard lock(mutex_);
        heard_.push_back(json::parse(boost::beast::buffers_to_string(received_.data())));
      }
      received_.clear();
      read();
    });
  }

  net::io_context context_;
  Tcp::acceptor acceptor_;
  net::steady_timer timer_{context_};
  std::optional<websocket::stream<Tcp::socket>> socket_;
  boost::beast::flat_buffer received_;
  mutable std::mutex mutex_;
  std::vector<json> heard_;
  std::string authorization_;
  std::thread thread_;
};

class AgainstAScript : public testing::Test {
 protected:
  void connect(const std::string& token = "") { client.connect("127.0.0.1", server.port(), token); }

  /// `force` comes every millisecond, and is what wrench() is asked for. \returns the last of them.
  double hold(double force, double seconds) {
    double shown = 0.0;
    for (const double end = Client::now() + seconds; Client::now() < end; sleep(1e-3)) {
      server.say(wrench_text(force));
      shown = client.wrench().force[2];
    }
    return shown;
  }
  /// Through the client's gate; where the machine stands still meanwhile, once more.
  bool open(double force) {
    for (int k = 0; k < 50; ++k) {
      hold(0.0, 0.02);
      if (hold(force, 0.13) > 0.9 * std::min(force, kDeviceForceMax)) return true;
    }
    return false;
  }
  bool falls() {
    return eventually([&] { return client.wrench().force[2] == 0.0; });
  }

  FakeServer server;
  Client client{{kDeviceForceMax, 0.0}};
};

TEST_F(AgainstAScript, SubscribesToWhatItNeedsAndShowsTheToken) {
  connect("s3cret");
  EXPECT_TRUE(client.is_connected());
  ASSERT_TRUE(eventually([&] { return server.heard().size() == 2; }));
  EXPECT_EQ(server.heard()[0], (json{{"op", "subscribe"}, {"topic", "/palpate/client/servo_cf"}}));
  EXPECT_EQ(server.heard()[1], (json{{"op", "subscribe"}, {"topic", "/palpate/client/echo"}}));
  EXPECT_EQ(server.authorization(), "Bearer s3cret");
}

TEST_F(AgainstAScript, SaysInOneLineWhyItCannotConnect) {
  const auto why = [&](const std::string& host, std::uint16_t port) -> std::string {
    try {
      client.connect(host, port);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  server.refuses = true;
  EXPECT_THAT(why("127.0.0.1", server.port()), testing::AllOf(HasSubstr("Unauthorized"), HasSubstr("token")));
  EXPECT_THAT(why("127.0.0.1", 1), testing::AllOf(HasSubstr("127.0.0.1:1: "), HasSubstr("refused")));
  EXPECT_FALSE(client.is_connected());
  EXPECT_EQ(client.wrench().force[2], 0.0);
  server.refuses = false;
  connect();
  EXPECT_TRUE(client.is_connected());
}

TEST_F(AgainstAScript, SendsItsPosesStampedInTheFrameOfTheDevice) {
  connect();
  client.send({{0.1, 0.2, 0.3}, {0.5, -0.5, 0.5, -0.5}}, 12345.678901234);
  ASSERT_TRUE(eventually([&] { return !server.heard(messages::kPose).empty(); }));
  const json sent = server.heard(messages::kPose)[0];
  EXPECT_EQ(sent["header"]["frame_id"], "device");
  EXPECT_EQ(sent["header"]["stamp"]["secs"], 12345);
  EXPECT_NEAR(sent["header"]["stamp"]["nsecs"].get<double>(), 678901234, 1000);
  EXPECT_EQ(sent["pose"]["position"], (json{{"x", 0.1}, {"y", 0.2}, {"z", 0.3}}));
  EXPECT_EQ(sent["pose"]["orientation"], (json{{"w", 0.5}, {"x", -0.5}, {"y", 0.5}, {"z", -0.5}}));
}

TEST_F(AgainstAScript, AnswersEveryEchoWithItsOwnClock) {
  connect();
  for (std::size_t number = 1; number < 10; ++number) {
    const double asked = Client::now();
    server.say(messages::publish(messages::kEcho,
                                 {{"seq", number}, {"stamp", messages::stamp(1e9)}, {"frame_id", ""}}));
    ASSERT_TRUE(eventually([&] { return server.heard(messages::kEchoed).size() == number; }));
    const double answered = Client::now();
    const json echoed = server.heard(messages::kEchoed).back();
    EXPECT_EQ(echoed["seq"], number);
    const double stamp =
        echoed["stamp"]["secs"].get<double>() + 1e-9 * echoed["stamp"]["nsecs"].get<double>();
    EXPECT_GT(stamp, asked - 1e-6);
    EXPECT_LT(stamp, answered + 1e-6);
  }
}

TEST_F(AgainstAScript, ShowsWhatComesWithinItsLimits) {
  connect();
  ASSERT_TRUE(open(5.0));
  ASSERT_TRUE(open(1e300));
  EXPECT_LE(hold(1e300, 0.02), kDeviceForceMax * (1 + 1e-12));
}

TEST_F(AgainstAScript, WhatIsNoMessageEndsInZeroUntilAWrenchIsSmall) {
  connect();
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = wrench_text(5.0);
    return text.replace(text.find(from), from.size(), to);
  };
  const std::vector<std::string> bad{"",
                                     "{",
                                     "null",
                                     "7",
                                     "[]",
                                     "{}",
                                     "[[[[[[[[",
                                     std::string(9000, '['),

                                     with("5.0", "NaN"),
                                     with("5.0", "1e999"),
                                     with("5.0", "null"),
                                     with("5.0", "\"5\""),
                                     with("5.0", "[5]"),
                                     with("\"force\"", "\"farce\""),
                                     with("\"wrench\"", "\"wench\""),
                                     with("\"torque\"", "\"talk\""),
                                     R"({"op":"publish","topic":"/palpate/client/servo_cf"})",
                                     R"({"op":"publish","topic":"/palpate/client/servo_cf","msg":5})",
                                     R"({"op":"publish","topic":"/palpate/client/echo","msg":{"seq":-1}})",
                                     R"({"op":"publish","topic":"/palpate/client/echo","msg":{"seq":"1"}})",
                                     R"({"op":"publish","topic":"/another","msg":{}})",
                                     R"({"op":{"op":"publish"}})"};
  for (const std::string& text : bad) {
    SCOPED_TRACE(text.substr(0, 200));
    ASSERT_TRUE(open(5.0));
    server.say(text);
    // What comes after it is as good as before: without the gate this would not fall.
    bool fell = false;
    for (int k = 0; k < 5000 && !fell; ++k) fell = hold(5.0, 2e-3) == 0.0;
    ASSERT_TRUE(fell);
    EXPECT_EQ(hold(5.0, 0.05), 0.0);
    EXPECT_TRUE(client.is_connected());
  }
  ASSERT_TRUE(open(5.0)) << "it is as before";
}

TEST_F(AgainstAScript, AMessageThatIsTooLongOrNoTextEndsTheConnectionAndTheForce) {
  for (const std::string& text : {std::string(1 << 20, ' '), std::string("\xff\xfe")}) {
    connect();
    ASSERT_TRUE(open(5.0));
    server.say(text);
    EXPECT_TRUE(eventually([&] { return !client.is_connected(); }));
    EXPECT_TRUE(falls());
  }
}

TEST_F(AgainstAScript, ALostConnectionEndsInZeroAndIsNotMadeAnewByItself) {
  connect();
  ASSERT_TRUE(open(5.0));
  const auto heard = server.heard().size();
  server.drop();
  EXPECT_TRUE(eventually([&] { return !client.is_connected(); }));
  EXPECT_TRUE(falls());
  client.send({{9, 9, 9}, {1, 0, 0, 0}}, Client::now());
  EXPECT_EQ(hold(5.0, 0.2), 0.0);
  EXPECT_EQ(server.heard().size(), heard);
  connect();
  EXPECT_EQ(hold(5.0, 0.2), 0.0) << "through the gate";
  ASSERT_TRUE(open(5.0));
  EXPECT_TRUE(server.heard(messages::kPose).empty()) << "what was measured before is not sent";
  client.disconnect();
  client.wrench();  // the line begins
  sleep(0.01);
  EXPECT_EQ(client.wrench().force[2], 0.0);
}

TEST_F(AgainstAScript, ASilentServerEndsInZero) {
  connect();
  ASSERT_TRUE(open(5.0));
  EXPECT_TRUE(falls());
  EXPECT_TRUE(client.is_connected());
}

TEST_F(AgainstAScript, TellsAPersonWhatItIsTold) {
  std::mutex mutex;
  std::string told;
  client.on_status = [&](const std::string& text) {
    const std::lock_guard lock(mutex);
    told += text;
  };
  connect();
  server.say(R"({"op":"status","level":"error","msg":"another client holds the tool"})");
  server.say(R"({"op":"status","level":"error"})");
  EXPECT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return told == "another client holds the tool";
  }));
}

TEST_F(AgainstAScript, NeitherSendingNorAskingTakesFromTheHeap) {
  connect();
  const palpate::test::AllocationGuard guard;
  for (int k = 0; k < 100; ++k) {
    client.send({}, Client::now());
    client.wrench();
  }
  EXPECT_EQ(guard.count(), 0U);
}

TEST(ThePosesOfAClient, AreNeverAQueueOfOldOnes) {
  constexpr int kPoses = 20'000;
  FakeServer server(4096);  // the kernel keeps little
  Client client({kDeviceForceMax, 0.0});
  client.connect("127.0.0.1", server.port());
  ASSERT_TRUE(eventually([&] { return server.heard().size() == 2; }));
  server.reads = false;
  client.send({{-1, 0, 0}, {1, 0, 0, 0}}, 1.0);  // ends the read that is under way
  ASSERT_TRUE(eventually([&] { return !server.heard(messages::kPose).empty(); }));
  for (int k = 1; k <= kPoses; ++k) {
    client.send({{1.0 * k, 0, 0}, {1, 0, 0, 0}}, k);
    if (k % 10 == 0) sleep(1e-4);
  }
  server.reads = true;
  ASSERT_TRUE(
      eventually([&] { return server.heard(messages::kPose).back()["pose"]["position"]["x"] == kPoses; }));
  EXPECT_LT(server.heard(messages::kPose).size(), kPoses / 20) << "but for what the kernel keeps";
}

#ifdef PALPATE_PROGRAM

/// `palpate run --device client` on a sphere of 0.15 m around the origin, felt with a ball of 20 mm.
class Program {
 public:
  Program() {
    run({PALPATE_PROGRAM, "make-scene", "sphere", "--out", scene_.path(), "-q"});
    int pipe[2];
    if (::pipe(pipe) != 0) throw std::runtime_error("no pipe");
    pid_ = spawn({PALPATE_PROGRAM, "run", scene_.path(), "--device", "client", "--port", "0", "--tool",
                  "0.02,0.02,0.02"},
                 pipe[1]);
    ::close(pipe[1]);
    FILE* said = ::fdopen(pipe[0], "r");
    char line[512];
    unsigned port = 0;
    while (port == 0 && std::fgets(line, sizeof line, said) != nullptr) {
      if (const char* at = std::strstr(line, "http://127.0.0.1:"))
        std::sscanf(at, "http://127.0.0.1:%u", &port);
    }
    said_ = said;
    port_ = static_cast<std::uint16_t>(port);
  }
  ~Program() {
    signal(SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    std::fclose(said_);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  std::uint16_t port() const { return port_; }
  void signal(int number) const { ::kill(pid_, number); }

 private:
  static pid_t spawn(std::vector<std::string> arguments, int out) {
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    if (out >= 0) ::posix_spawn_file_actions_adddup2(&actions, out, STDERR_FILENO);
    pid_t pid = 0;
    const int failed = ::posix_spawn(&pid, pointers[0], &actions, nullptr, pointers.data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) throw std::runtime_error("the program cannot be started");
    return pid;
  }
  static void run(const std::vector<std::string>& arguments) {
    int status = 0;
    ::waitpid(spawn(arguments, -1), &status, 0);
    if (status != 0) throw std::runtime_error("the scene cannot be made");
  }

  palpate::test::TemporaryFile scene_{"", "sphere.ply"};
  pid_t pid_ = 0;
  FILE* said_ = nullptr;
  std::uint16_t port_ = 0;
};

/// A handle that is led up and down above the sphere, 1000 times a second.
class AgainstTheProgram : public testing::Test {
 protected:
  static constexpr double kFree = 0.19,
                          kPressed = 0.165;  // heights of the ball; it touches at 0.17. Unit: [m].
  /// Of wrenches that had been sent before, on a machine that does much else. Unit: [s].
  static constexpr double kOnTheWay = 0.03;
  struct Shown {
    double t, force;  // s, N
  };

  void SetUp() override {
    client.on_status = [this](const std::string& text) {
      const std::lock_guard lock(mutex);
      told += text + "\n";
    };
    client.connect("127.0.0.1", program.port());
  }

  /// Goes to `height` at 0.1 m/s and stays, or ends at a force. \returns what was shown each millisecond.
  std::vector<Shown> lead(double height, double seconds, double until_force = 1e9) {
    std::vector<Shown> all;
    const double begin = Client::now();
    for (int tick = 1; Client::now() < begin + seconds; ++tick) {
      z += std::clamp(height - z, -1e-4, 1e-4);
      if (speaks) client.send({{0, 0, z}, {1, 0, 0, 0}}, Client::now() - late);
      const double t = Client::now();
      all.push_back({t, client.wrench({0, 0, z}).force[2]});
      if (all.back().force > until_force) break;
      std::this_thread::sleep_for(std::chrono::duration<double>(begin + 1e-3 * tick - Client::now()));
    }
    return all;
  }
  /// No more from then on than what the client's gate lets pass while the program's own force falls.
  static void expect_no_force(const std::vector<Shown>& all, double from) {
    for (const Shown& shown : all) {
      if (shown.t > from) {
        EXPECT_LE(std::abs(shown.force), 0.05) << shown.t - from << " s too late";
      }
    }
  }
  /// Onto the sphere until there is a force; a machine that stands still for a moment is a fault: then again.
  bool press() {
    for (int k = 0; k < 60; ++k) {
      lead(kFree, 1.2);
      if (lead(kPressed, 0.8, 1.0).back().force > 1.0) return true;
    }
    return false;
  }
  std::string what_was_told() {
    const std::lock_guard lock(mutex);
    return told;
  }

  explicit AgainstTheProgram(double damping = 0.0) : client({kDeviceForceMax, 0.0, damping}) {}

  Program program;
  Client client;
  double z = kFree, late = 0.0;
  bool speaks = true;
  std::mutex mutex;
  std::string told;
};

TEST_F(AgainstTheProgram, AForceComesAtTheRateOfTheLoop) {
  ASSERT_TRUE(press());
  const std::uint64_t before = client.wrench_count();
  lead(kPressed, 1.0);
  EXPECT_GE(client.wrench_count() - before, 300U) << "of 1000";
}

TEST_F(AgainstTheProgram, AProgramThatIsStoppedEndsInZeroAndGoesOnThroughTheGate) {
  ASSERT_TRUE(press());
  program.signal(SIGSTOP);
  const double stopped = Client::now();
  expect_no_force(lead(kPressed, 0.4), stopped + kOnTheWay + WrenchGovernor::kSilence);
  program.signal(SIGCONT);
  expect_no_force(lead(kPressed, 0.5), stopped);  // pressed: no gate opens
  EXPECT_TRUE(press()) << "it is felt anew";
}

TEST_F(AgainstTheProgram, AProgramThatIsKilledEndsInZero) {
  ASSERT_TRUE(press());
  program.signal(SIGKILL);
  const double killed = Client::now();
  expect_no_force(lead(kPressed, 0.3), killed + kOnTheWay + WrenchGovernor::kSilence);
  EXPECT_TRUE(eventually([&] { return !client.is_connected(); }));
}

TEST_F(AgainstTheProgram, AHandThatWasSilentFeelsNoStep) {
  ASSERT_TRUE(press());
  speaks = false;
  const double silent = Client::now();
  expect_no_force(lead(kPressed, 0.3), silent + WrenchGovernor::kSilence);
  speaks = true;
  expect_no_force(lead(kPressed, 0.5), silent);
  EXPECT_TRUE(press());
}

/// The same with the force of the local model.
class WithALocalModel : public AgainstTheProgram {
 protected:
  WithALocalModel() : AgainstTheProgram(1.0) {}  // N s/m

  /// Of what was shown while the handle was nowhere else; NaN if there was a fault.
  double force_at(double height) {
    lead(height, 0.2);
    const std::vector<Shown> all = lead(height, 0.3);
    const auto [least, most] = std::minmax_element(
        all.begin(), all.end(), [](const Shown& a, const Shown& b) { return a.force < b.force; });
    return most->force - least->force < 0.05 ? most->force : std::nan("");
  }
};

// 500 N/m as it is set. The program's own force is softer: for poses that may be 1/60 s apart, 3 N s/m / 8
// ms.
TEST_F(WithALocalModel, ItIsAsStiffAsTheProgramIsSet) {
  constexpr double kDeep = 500.0 * (0.170 - 0.166),
                   kLarger = 0.3;  // the sphere of Gaussians is a little larger
  constexpr double kMore = 500.0 * 0.003, kOff = 0.05;
  double deep = std::nan(""), deeper = std::nan("");
  const auto is_stiff = [&] {
    return std::abs(deep - kDeep) <= kLarger && std::abs(deeper - deep - kMore) <= kOff;
  };
  // Again after a fault, and where a machine that stood still left less energy than the force takes.
  for (int k = 0; k < 5 && !is_stiff(); ++k) {
    ASSERT_TRUE(press());
    deep = force_at(0.166);
    deeper = force_at(0.163);
  }
  EXPECT_NEAR(deep, kDeep, kLarger);
  EXPECT_NEAR(deeper - deep, kMore, kOff);
}

TEST_F(WithALocalModel, AProgramThatIsKilledEndsInZero) {
  ASSERT_TRUE(press());
  program.signal(SIGKILL);
  const double killed = Client::now();
  expect_no_force(lead(kPressed, 0.3), killed + kOnTheWay + WrenchGovernor::kSilence);
}

TEST_F(WithALocalModel, AProgramThatIsStoppedEndsInZero) {
  ASSERT_TRUE(press());
  program.signal(SIGSTOP);
  const double stopped = Client::now();
  expect_no_force(lead(kPressed, 0.3), stopped + kOnTheWay + WrenchGovernor::kSilence);
}

TEST_F(AgainstTheProgram, ItsEchoesTellHowOldItsPosesAre) {
  late = 0.06;
  for (int k = 0; k < 50 && what_was_told().find("after measurement") == std::string::npos; ++k)
    lead(kFree, 0.1);
  EXPECT_THAT(what_was_told(), HasSubstr("ms after measurement; those older than"));
}

#endif

}  // namespace
}  // namespace palpate_client

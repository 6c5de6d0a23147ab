/// \file
/// Reference client of Palpate's gateway: makes a force-feedback device the device of `palpate run --device
/// client`.
///
/// One header, without the Palpate library. Needs C++20, Linux, and Debian's libboost-dev and
/// nlohmann-json3-dev:
///
///     g++ -std=c++20 -O2 -pthread main.cpp -o palpate_client
///
/// What a client must do is listed in docs/gateway.md; palpate_client.mjs is the same in JavaScript.
///
/// Conventions: SI units; quaternions are w, x, y, z; everything is in the device's own right-handed frame,
/// which the
/// `--workspace-*` options of the program place in the world.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include <sys/eventfd.h>
#include <unistd.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/use_future.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>

namespace palpate_client {

/// Pose of the handle in the device's frame.
struct Pose {
  std::array<double, 3> position{};               ///< Unit: [m].
  std::array<double, 4> orientation{1, 0, 0, 0};  ///< w, x, y, z; unit norm, handle to device
};

/// What the hand receives at the handle, in the device's frame.
struct Wrench {
  std::array<double, 3> force{};   ///< Unit: [N].
  std::array<double, 3> torque{};  ///< About the handle's origin. Unit: [N m].
};

/// The largest that the device may show.
struct Limits {
  double force_max = 0.0;   ///< Unit: [N]. > 0
  double torque_max = 0.0;  ///< 0 for a device without motors for the orientation. Unit: [N m]. >= 0
};

/// The newest value from one thread to another: a triple buffer. Neither thread locks, allocates or waits.
template <class T>
class Newest {
 public:
  /// The writing thread.
  void put(const T& value) noexcept {
    places_[back_] = value;
    back_ = between_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kPlace;
  }
  /// The reading thread. True if get() is another value than before.
  bool update() noexcept {
    if ((between_.load(std::memory_order_relaxed) & kFresh) == 0U) return false;
    front_ = between_.exchange(front_, std::memory_order_acq_rel) & kPlace;
    return true;
  }
  /// The reading thread.
  const T& get() const noexcept { return places_[front_]; }

 private:
  static constexpr unsigned kPlace = 3, kFresh = 4;
  std::array<T, 3> places_{};
  unsigned back_ = 0, front_ = 1;
  std::atomic<unsigned> between_ = 2;
};

/// Stands between the wrenches that come over the network and the motors. What show() returns is
///
///  - finite, and within the limits: a larger wrench is scaled down in its direction;
///  - zero before the first wrench, and from kSilence on after the pose that the last wrench answers was
///  measured:
///    where none comes any longer, where they come ever later, and where no pose has gone out;
///  - zero from kFall after the call that first sees a wrench that is not finite, a message that is none, or
///  the
///    loss of the connection;
///  - after any of these, or after show() itself was not called for kSilence, zero until a wrench is small
///  (kGate),
///    and then a share that rises from zero to one within kRise. The program's own gate may not have noticed.
///
/// A drop is a straight line of kFall and not a step, which a hand feels as a knock and which excites the
/// device; the line begins early enough to end at kSilence.
///
/// Has no clock: all times are arguments, in seconds on one clock that never falls. One thread calls take()
/// and fail(), one calls show(); nothing here locks, allocates, throws or waits.
class WrenchGovernor {
 public:
  static constexpr double kSilence = 0.05;  ///< Unit: [s].
  static constexpr double kFall = 0.005;    ///< Unit: [s].
  static constexpr double kRise = 0.1;      ///< Unit: [s].
  static constexpr double kGate = 0.05;     ///< Share of force_max and of torque_max.

  /// \throws std::invalid_argument for limits that are none
  explicit WrenchGovernor(const Limits& limits) : limits_(limits) {
    if (!(limits.force_max > 0.0 && std::isfinite(limits.force_max)))
      throw std::invalid_argument("force_max must be above 0 N");
    if (!(limits.torque_max >= 0.0 && std::isfinite(limits.torque_max)))
      throw std::invalid_argument("torque_max must be 0 N m or more");
  }

  /// A wrench came at `t`, as the answer to a pose that was measured at `measured_at`.
  void take(const Wrench& wrench, double measured_at, double t) noexcept {
    if (!is_finite(wrench)) return fail();
    if (!(t - measured_at <= kSilence)) return;  // also where it answers none
    if (t - last_.t > kSilence) ++last_.breaks;
    last_ = {{clamped(wrench.force, limits_.force_max), clamped(wrench.torque, limits_.torque_max)},
             std::min(measured_at, t),
             true,
             last_.breaks};
    heard_.put(last_);
  }

  /// Something came that is no wrench, or the connection is lost.
  void fail() noexcept {
    last_.good = false;
    ++last_.breaks;
    heard_.put(last_);
  }

  /// What the motors shall show at `now`.
  Wrench show(double now) noexcept {
    heard_.update();
    const Heard& heard = heard_.get();
    const double zero_at = heard.t + kSilence;
    const bool lost =
        !heard.good || heard.breaks != breaks_ || now > zero_at - kFall || now - shown_at_ > kSilence;
    breaks_ = heard.breaks;
    shown_at_ = now;
    if (state_ == State::kOpen && lost) {
      state_ = State::kFalling;
      since_ = now;
      fall_end_ = std::min(now + kFall, zero_at);
      falls_from_ = shown_;
    }
    if (state_ == State::kFalling && now >= fall_end_) state_ = State::kClosed;
    if (state_ == State::kClosed && !lost && is_small(heard.wrench)) {
      state_ = State::kOpen;
      since_ = now;
    }
    shown_ = in_this_state(now);
    return shown_;
  }

 private:
  enum class State { kClosed, kOpen, kFalling };
  struct Heard {
    Wrench wrench;
    double t =
        -std::numeric_limits<double>::infinity();  ///< when the pose was measured that it answers. Unit: [s].
    bool good = false;
    std::uint64_t breaks = 0;  ///< silences and failures so far: show() may be too slow to see each
  };

  static double norm(const std::array<double, 3>& v) noexcept { return std::hypot(v[0], v[1], v[2]); }
  static bool is_finite(const Wrench& w) noexcept {
    const auto finite = [](double x) { return std::isfinite(x); };
    return std::all_of(w.force.begin(), w.force.end(), finite) &&
           std::all_of(w.torque.begin(), w.torque.end(), finite);
  }
  static std::array<double, 3> scaled(std::array<double, 3> v, double factor) noexcept {
    for (double& x : v) x *= factor;
    return v;
  }
  static Wrench scaled(const Wrench& w, double factor) noexcept {
    return {scaled(w.force, factor), scaled(w.torque, factor)};
  }
  static std::array<double, 3> clamped(const std::array<double, 3>& v, double most) noexcept {
    const double length = norm(v);
    return length > most ? scaled(v, most / length) : v;
  }
  bool is_small(const Wrench& w) const noexcept {
    return norm(w.force) <= kGate * limits_.force_max && norm(w.torque) <= kGate * limits_.torque_max;
  }

  Wrench in_this_state(double now) const noexcept {
    switch (state_) {
      case State::kOpen: return scaled(heard_.get().wrench, std::min(1.0, (now - since_) / kRise));
      case State::kFalling: return scaled(falls_from_, (fall_end_ - now) / (fall_end_ - since_));
      case State::kClosed: break;
    }
    return {};
  }

  const Limits limits_;
  Heard last_;  ///< the network's thread
  Newest<Heard> heard_;

  // The servo thread.
  State state_ = State::kClosed;
  std::uint64_t breaks_ = 0;
  double shown_at_ = -std::numeric_limits<double>::infinity();  ///< Unit: [s].
  double since_ = 0.0, fall_end_ = 0.0;                         ///< of the state. Unit: [s].
  Wrench shown_, falls_from_;
};

/// The messages of rosbridge v2 that a client needs.
namespace messages {

using Json = nlohmann::json;

inline constexpr const char* kPose = "/palpate/client/measured_cp";
inline constexpr const char* kWrench = "/palpate/client/servo_cf";
inline constexpr const char* kEcho = "/palpate/client/echo";
inline constexpr const char* kEchoed = "/palpate/client/echoed";
inline constexpr double kBillion = 1e9;

/// A time in seconds as ROS writes it.
inline Json stamp(double t) {
  const auto nanoseconds = static_cast<std::int64_t>(std::llround(t * kBillion));
  return {{"secs", nanoseconds / 1'000'000'000}, {"nsecs", nanoseconds % 1'000'000'000}};
}

inline std::string publish(const char* topic, Json message) {
  return Json{{"op", "publish"}, {"topic", topic}, {"msg", std::move(message)}}.dump();
}

inline std::string subscribe(const char* topic) { return Json{{"op", "subscribe"}, {"topic", topic}}.dump(); }

inline std::string pose(const Pose& pose, double measured_at) {
  const auto& [p, q] = pose;
  return publish(kPose, {{"header", {{"stamp", stamp(measured_at)}, {"frame_id", "device"}}},
                         {"pose",
                          {{"position", {{"x", p[0]}, {"y", p[1]}, {"z", p[2]}}},
                           {"orientation", {{"w", q[0]}, {"x", q[1]}, {"y", q[2]}, {"z", q[3]}}}}}});
}

inline std::string echoed(std::uint64_t number, double t) {
  return publish(kEchoed, {{"seq", number}, {"stamp", stamp(t)}, {"frame_id", ""}});
}

/// The member of that name; null where there is none.
inline const Json& at(const Json& from, const char* name) {
  static const Json none;
  const auto found = from.find(name);
  return found == from.end() ? none : *found;
}

/// NaN for what is no number.
inline double number(const Json& json) {
  return json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

/// Likewise.
inline std::array<double, 3> vector3(const Json& json) {
  return {number(at(json, "x")), number(at(json, "y")), number(at(json, "z"))};
}

/// A WrenchStamped, and the time that it is stamped with; NaN for what is missing.
inline std::pair<Wrench, double> wrench(const Json& message) {
  const Json& stamp = at(at(message, "header"), "stamp");
  const Json& wrench = at(message, "wrench");
  return {{vector3(at(wrench, "force")), vector3(at(wrench, "torque"))},
          number(at(stamp, "secs")) + number(at(stamp, "nsecs")) / kBillion};
}

}  // namespace messages

/// A connection to a running `palpate run --device client`. Three kinds of threads use it:
///
///  - its owner's: construction, connect(), disconnect(), on_status;
///  - the device's servo thread: send() and wrench(), from first to last the same thread, at 0.1 to 4 kHz
///  (the program
///    refuses more than 5000 messages a second);
///  - one of its own, for the network, while it is connected.
class Client {
 public:
  /// \param limits of the device. \throws std::invalid_argument, std::system_error
  explicit Client(const Limits& limits)
      : governor_(limits), ready_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    if (ready_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
  }
  ~Client() {
    disconnect();
    ::close(ready_);
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Connects, after disconnecting where it is connected. Nothing else connects it again: who has lost a
  /// connection decides when to hold the tool once more. Takes as long as kPatience for each of three steps.
  /// \param token that the program wants where it listens to other machines. \throws std::runtime_error
  void connect(const std::string& host, std::uint16_t port, const std::string& token = "") {
    disconnect();
    poses_.update();  // what was measured before is not sent
    connection_ = std::make_unique<Connection>(ready_);
    connection_->thread = std::thread([this, &connection = *connection_] { run(connection); });
    try {
      open(*connection_, host, std::to_string(port), token);
    } catch (const std::exception& error) {
      disconnect();
      throw std::runtime_error(host + ":" + std::to_string(port) + ": " + error.what());
    }
  }

  /// The force falls to zero. Does not throw.
  void disconnect() {
    if (!connection_) return;
    connection_->context.stop();
    connection_->thread.join();
    connection_.reset();
    connected_ = false;
    governor_.fail();  // its thread is gone
  }

  /// Whether the connection is there; a program that hangs still has one. Any thread.
  bool is_connected() const noexcept { return connected_; }

  /// What the program tells this client, for a person: another client holds the tool, a pose is refused or
  /// too late. Called on the network's thread. Set it before connect(); it must not throw.
  std::function<void(const std::string& text)> on_status;

  /// The clock that poses are stamped with and echoes are answered with: monotonic. Any thread. Unit: [s].
  static double now() noexcept {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }

  /// The pose of the handle, measured at `measured_at` of now(). Unit: [s]. It replaces one that is not sent
  /// yet. The servo thread: neither locks, allocates nor blocks.
  void send(const Pose& pose, double measured_at) noexcept {
    poses_.put({pose, measured_at});
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(ready_, &one, sizeof one);
  }

  /// What the motors shall show now: see WrenchGovernor. The servo thread, at least every 50 ms: neither
  /// locks, allocates nor blocks.
  Wrench wrench() noexcept { return governor_.show(now()); }

  /// How many wrenches have come so far. Any thread.
  std::uint64_t wrench_count() const noexcept { return wrench_count_; }

  static constexpr std::chrono::seconds kPatience{5};

 private:
  using Tcp = boost::asio::ip::tcp;
  using ErrorCode = boost::system::error_code;
  struct TimedPose {
    Pose pose;
    double t = 0.0;  ///< Unit: [s].
  };

  /// What lives from connect() to disconnect(). Belongs to its thread.
  struct Connection {
    explicit Connection(int ready) : ready(context, ::dup(ready)) {}
    boost::asio::io_context context{1};
    boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work{context.get_executor()};
    boost::asio::posix::stream_descriptor ready;  ///< readable: there is a pose to send
    Tcp::resolver resolver{context};
    boost::beast::websocket::stream<Tcp::socket, false> socket{context};
    boost::beast::websocket::response_type response;
    boost::beast::flat_buffer received;
    std::string sent;  ///< while it is being written
    std::string echo;  ///< the newest that waits to be written; empty: none
    bool writing = false;
    std::thread thread;
  };

  /// Of a message; those for a client have less than 1 KiB.
  static constexpr std::size_t kMostReceived = 16 << 10;
  /// Of poses on the way: the less the kernel keeps, the newer is what is sent when a network recovers. Unit:
  /// [B].
  static constexpr int kSendBuffer = 16 << 10;

  template <class T>
  static T finish(std::future<T> future) {
    if (future.wait_for(kPatience) != std::future_status::ready) throw std::runtime_error("does not answer");
    return future.get();
  }

  void open(Connection& connection, const std::string& host, const std::string& port,
            const std::string& token) {
    namespace net = boost::asio;
    namespace websocket = boost::beast::websocket;
    const std::string name = host + ":" + port;
    const auto addresses = finish(connection.resolver.async_resolve(host, port, net::use_future));
    Tcp::socket& tcp = connection.socket.next_layer();
    finish(net::async_connect(tcp, addresses, net::use_future));
    tcp.set_option(Tcp::no_delay(true));
    tcp.set_option(net::socket_base::send_buffer_size(kSendBuffer));
    connection.socket.set_option(websocket::stream_base::decorator([token](websocket::request_type& request) {
      if (!token.empty()) request.set(boost::beast::http::field::authorization, "Bearer " + token);
    }));
    connection.socket.read_message_max(kMostReceived);
    try {
      finish(connection.socket.async_handshake(connection.response, name, "/", net::use_future));
    } catch (const boost::system::system_error& error) {
      if (error.code() != websocket::error::upgrade_declined) throw;
      throw std::runtime_error("refuses the connection: " + std::string(connection.response.reason()) +
                               (connection.response.result_int() == 401 ? "; give its token" : ""));
    }
    for (const char* topic : {messages::kWrench, messages::kEcho}) {
      connection.sent = messages::subscribe(topic);
      finish(connection.socket.async_write(net::buffer(connection.sent), net::use_future));
    }
    connected_ = true;
    net::post(connection.context, [this, &connection] {
      read(connection);
      wait_for_pose(connection);
    });
  }

  void run(Connection& connection) {
    try {
      connection.context.run();
    } catch (const std::exception&) {  // out of memory
    }
    lost(connection);
  }

  void lost(Connection& connection) {
    connected_ = false;
    governor_.fail();
    connection.context.stop();
  }

  void read(Connection& connection) {
    connection.socket.async_read(connection.received, [this, &connection](ErrorCode error, std::size_t) {
      if (error) return lost(connection);
      const auto bytes = connection.received.cdata();
      hear(connection, {static_cast<const char*>(bytes.data()), bytes.size()});
      connection.received.consume(connection.received.size());
      read(connection);
    });
  }

  void hear(Connection& connection, std::string_view text) {
    using messages::at;
    const double t = now();
    const nlohmann::json message = nlohmann::json::parse(text, nullptr, false);
    if (at(message, "op") == "status") return tell(at(message, "msg"));
    if (at(message, "op") != "publish") return governor_.fail();
    const nlohmann::json& content = at(message, "msg");
    if (at(message, "topic") == messages::kEcho) return answer(connection, at(content, "seq"), t);
    if (at(message, "topic") != messages::kWrench) return governor_.fail();
    const auto [wrench, measured_at] = messages::wrench(content);
    governor_.take(wrench, measured_at, t);
    wrench_count_.fetch_add(1, std::memory_order_relaxed);
  }

  void tell(const nlohmann::json& text) const {
    if (on_status && text.is_string()) on_status(text.get<std::string>());
  }

  void answer(Connection& connection, const nlohmann::json& number, double t) {
    if (!number.is_number_unsigned()) return governor_.fail();
    connection.echo = messages::echoed(number.get<std::uint64_t>(), t);
    write(connection);
  }

  void wait_for_pose(Connection& connection) {
    connection.ready.async_wait(connection.ready.wait_read, [this, &connection](ErrorCode error) {
      if (error) return lost(connection);
      std::uint64_t count = 0;
      [[maybe_unused]] const auto read = ::read(connection.ready.native_handle(), &count, sizeof count);
      write(connection);
      wait_for_pose(connection);
    });
  }

  /// An echo first, then the newest pose there is.
  void write(Connection& connection) {
    if (connection.writing) return;
    if (!connection.echo.empty()) {
      connection.sent = std::exchange(connection.echo, {});
    } else if (poses_.update()) {
      connection.sent = messages::pose(poses_.get().pose, poses_.get().t);
    } else {
      return;
    }
    connection.writing = true;
    connection.socket.async_write(boost::asio::buffer(connection.sent),
                                  [this, &connection](ErrorCode error, std::size_t) {
                                    connection.writing = false;
                                    if (error) return lost(connection);
                                    write(connection);
                                  });
  }

  WrenchGovernor governor_;
  Newest<TimedPose> poses_;
  int ready_;  ///< an eventfd: how the servo thread wakes the network's without a lock
  std::atomic<bool> connected_ = false;
  std::atomic<std::uint64_t> wrench_count_ = 0;
  std::unique_ptr<Connection> connection_;
};

}  // namespace palpate_client

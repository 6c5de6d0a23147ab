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
#include <vector>

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

using Vector = std::array<double, 3>;

/// What the hand receives at the handle, in the device's frame.
struct Wrench {
  Vector force{};   ///< Unit: [N].
  Vector torque{};  ///< About the handle's origin. Unit: [N m].
};

/// The largest that the device may show, and what it absorbs.
struct Limits {
  double force_max = 0.0;   ///< Unit: [N]. > 0
  double torque_max = 0.0;  ///< 0 for a device without motors for the orientation. Unit: [N m]. >= 0
  /// The least viscous damping of the device and the hand that holds it. Above 0 local models are rendered,
  /// no stiffer than it keeps passive: see LocalRenderer. Unit: [N s/m]. >= 0
  double damping = 0.0;
};

/// A plane that the handle stays before.
struct Plane {
  Vector point{};   ///< Unit: [m].
  Vector normal{};  ///< unit, outward
};

/// The surface about the handle, as palpate/LocalModel of docs/gateway.md has it.
struct LocalModel {
  static constexpr std::size_t kMost = 4;

  Vector position{};                  ///< of the handle that it was made for. Unit: [m].
  std::array<Plane, kMost> planes{};  ///< the first `count`
  std::size_t count = 0;
  double stiffness = 0.0;  ///< 0: there is no local model, and the wrench is shown. Unit: [N/m].
  double damping = 0.0;    ///< Unit: [N s/m].
  double friction = 0.0;   ///< Coulomb's coefficient
  double share = 0.0;      ///< of the force that the program lets through now, in [0, 1]
};

namespace vectors {

inline double dot(const Vector& a, const Vector& b) noexcept {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
/// \pre finite: std::hypot may take a NaN for nothing.
inline double norm(const Vector& v) noexcept { return std::hypot(v[0], v[1], v[2]); }
inline Vector scaled(Vector v, double factor) noexcept {
  for (double& x : v) x *= factor;
  return v;
}
/// a + factor b.
inline Vector sum(const Vector& a, const Vector& b, double factor = 1.0) noexcept {
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}
inline Vector clamped(const Vector& v, double most) noexcept {
  const double length = norm(v);
  return length > most ? scaled(v, most / length) : v;
}
inline bool is_finite(const Vector& v) noexcept {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}
/// Whether it is a place: finite, and near enough that nothing made of it overflows. Unit: [m].
inline bool is_place(const Vector& v) noexcept {
  constexpr double kFarthest = 1e6;
  return is_finite(v) && norm(v) <= kFarthest;
}

}  // namespace vectors

/// Whether a model that has come may be rendered.
inline bool is_good(const LocalModel& model) noexcept {
  constexpr double kUnit = 1e-3;
  const auto amount = [](double x) { return std::isfinite(x) && x >= 0.0; };
  bool good = model.count <= LocalModel::kMost && vectors::is_place(model.position) &&
              amount(model.stiffness) && amount(model.damping) && amount(model.friction) &&
              amount(model.share) && model.share <= 1.0;
  for (std::size_t k = 0; good && k < model.count; ++k) {
    const auto& [point, normal] = model.planes[k];
    good = vectors::is_place(point) && vectors::is_finite(normal) &&
           std::abs(vectors::norm(normal) - 1.0) <= kUnit;
  }
  return good;
}

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

/// Makes the force of a LocalModel at the rate of the device, in place of one that is as late as the network
/// is. A spring of the model's stiffness leads from the handle to a proxy: the nearest place before all
/// planes on the way from where the proxy was, with friction (god-object, Zilles and Salisbury 1995), as
/// ProxyForce of the program has it.
///
/// Passive whatever planes come and however they differ from those before. With F the force that was shown
/// since the last call, d the way of the handle since then, dt the time but no less than T = kPeriod, and b
/// Limits::damping,
///
///     E' = E - F . d + b d^2 / dt           what the hand has put in, and what the device has absorbed
///     |F'| <= 2 sqrt(b E' / T)              so that (F' - 2 b d / T)^2 >= 0 leaves E'' >= 0, whatever d is
///     E  = min(E', max(k L^2 / 2, F'^2 T / 4 b))
///
/// where L is the length of the spring. Of that length, f = min(L, sqrt(2 E' / k)) is felt: a plane that
/// comes towards the handle winds up nothing, and what is missing comes as the hand moves. A plane alone is
/// felt in full if k <= 2 b / T (Colgate and Schenkel 1997); a stiffer model is rendered with that. The sum
/// of F . d is thus never more than that of b d^2 / dt, which the device absorbs, but for what a call later
/// than T makes of a plane stiffer than 2 b / dt; that is a debt, and no force is shown until it is paid.
///
/// Positions are taken as measured: a device that counts in coarse steps moves less than b d^2 / dt says.
///
/// One thread; nothing here locks, allocates, throws or waits.
class LocalRenderer {
 public:
  static constexpr double kPeriod = 1e-3;    ///< between calls, at most. Unit: [s].
  static constexpr double kSlewTime = 0.01;  ///< from no force to all, however often called. Unit: [s].
  static constexpr double kGap = 0.05;       ///< between calls, after which it begins anew. Unit: [s].
  static constexpr double kJump = 0.05;      ///< that no hand makes between calls. Unit: [m].

  explicit LocalRenderer(const Limits& limits) noexcept : limits_(limits) {}

  /// The force at `position`, and no more than most(). \pre is_good(model)
  Vector ask(const LocalModel& model, const Vector& position, double now) noexcept {
    const Vector way = vectors::sum(position, position_, -1.0);
    if (!vectors::is_place(position) || !(now - t_ <= kGap) || vectors::norm(way) > kJump) {
      restart(position, now);
      return {};
    }
    const double passed = std::max(0.0, now - t_), dt = std::max(passed, kPeriod);
    energy_ += limits_.damping * vectors::dot(way, way) / dt - vectors::dot(shown_, way);
    velocity_ = vectors::sum(velocity_, vectors::sum(vectors::scaled(way, 1.0 / dt), velocity_, -1.0),
                             -std::expm1(-dt / kVelocityFilter));
    position_ = position;
    t_ = now;
    proxy_ = nearest(model, proxy_, position);
    const Vector pull = vectors::sum(proxy_, position, -1.0);
    const double length = vectors::norm(pull);
    const double k = std::min(model.stiffness * model.share, 2.0 * limits_.damping / kPeriod);
    stored_ = 0.5 * k * length * length;
    pressed_ = model.stiffness * length;
    const Vector wanted = length > 0.0 ? spring(model, pull, k) : Vector{};
    const Vector change = vectors::sum(wanted, shown_, -1.0);
    return vectors::clamped(
        vectors::sum(shown_, vectors::clamped(change, limits_.force_max * passed / kSlewTime)), most());
  }

  /// What is shown from now on, of what was asked for. \pre no more than most()
  void show(const Vector& force) noexcept {
    shown_ = force;
    energy_ =
        std::min(energy_, std::max(stored_, vectors::dot(force, force) * kPeriod / (4.0 * limits_.damping)));
  }

  /// The largest force that has the energy behind it. Unit: [N].
  double most() const noexcept { return 2.0 * std::sqrt(limits_.damping * std::max(0.0, energy_) / kPeriod); }
  /// That the whole of the spring would show, however stiff. Unit: [N].
  double pressed() const noexcept { return pressed_; }
  /// E; below zero a debt. Unit: [J].
  double energy() const noexcept { return energy_; }

  /// Forgets all but a debt.
  void reset() noexcept { restart({}, -std::numeric_limits<double>::infinity()); }

 private:
  static constexpr double kVelocityFilter = 0.005;  ///< Unit: [s].
  static constexpr int kSweeps = 32;                ///< of the planes: four that form a corner settle in ten

  void restart(const Vector& position, double now) noexcept {
    position_ = proxy_ = position;
    t_ = vectors::is_place(position) ? now : -std::numeric_limits<double>::infinity();
    velocity_ = shown_ = {};
    stored_ = pressed_ = 0.0;
    energy_ = std::min(0.0, energy_);
  }

  /// What is felt of the spring, with the model's damping: at most twice as much, and never a pull.
  Vector spring(const LocalModel& model, const Vector& pull, double k) const noexcept {
    const double length = vectors::norm(pull);
    const double force = std::min(k * length, std::sqrt(2.0 * k * std::max(0.0, energy_)));
    const double outward = vectors::dot(velocity_, pull) / length;
    const double damped = force - std::min(model.damping, limits_.damping) * model.share * outward;
    return vectors::scaled(pull, std::clamp(damped, 0.0, 2.0 * force) / length);
  }

  /// Projected Gauss-Seidel sweeps over pushes and drags, as constrained_motion() of the program.
  static Vector nearest(const LocalModel& model, const Vector& from, const Vector& to) noexcept {
    Vector motion = vectors::sum(to, from, -1.0);
    std::array<double, LocalModel::kMost> pushes{};
    std::array<Vector, LocalModel::kMost> drags{};
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      for (std::size_t k = 0; k < model.count; ++k) {
        const auto& [point, normal] = model.planes[k];
        const double gap = vectors::dot(normal, vectors::sum(from, point, -1.0));
        const double step = std::max(-pushes[k], -(gap + vectors::dot(normal, motion)));
        pushes[k] += step;
        motion = vectors::sum(motion, normal, step);
        const Vector slip = vectors::sum(motion, normal, -vectors::dot(normal, motion));
        const Vector drag = vectors::clamped(vectors::sum(drags[k], slip, -1.0), model.friction * pushes[k]);
        motion = vectors::sum(motion, vectors::sum(drag, drags[k], -1.0));
        drags[k] = drag;
      }
    }
    return vectors::sum(from, motion);
  }

  const Limits limits_;
  Vector position_{}, proxy_{}, velocity_{};             ///< of the last call. Unit: [m], [m/s].
  double t_ = -std::numeric_limits<double>::infinity();  ///< likewise. Unit: [s].
  Vector shown_{};                                       ///< Unit: [N].
  double energy_ = 0.0, stored_ = 0.0;                   ///< E, and what the whole spring holds. Unit: [J].
  double pressed_ = 0.0;                                 ///< Unit: [N].
};

/// Where a force begins and ends. After a loss it falls to zero along a straight line, since a step is felt
/// as a knock and excites the device; it is zero until what is asked for is small, and then a share of it
/// that rises from zero to one.
class ForceGate {
 public:
  static constexpr double kSilence = 0.05;  ///< Unit: [s].
  static constexpr double kFall = 0.005;    ///< Unit: [s].
  static constexpr double kRise = 0.1;      ///< Unit: [s].

  /// \param small what is asked for may open it \param broken zero within kFall \param zero_at nothing is
  /// left from then on. Unit: [s]. Not being called for kSilence closes it at once: by then a watchdog may
  /// have switched the motors off, and a line that begins at the force before would be a step for the hand.
  /// So does a clock that was set back.
  Wrench pass(const Wrench& asked, bool small, bool broken, double zero_at, double now) noexcept {
    const bool stalled = !(now >= passed_at_ && now - passed_at_ <= kSilence);
    const bool lost = broken || now > zero_at - kFall || stalled;
    passed_at_ = now;
    if (stalled) state_ = State::kClosed;
    if (state_ == State::kOpen && lost) {
      state_ = State::kFalling;
      since_ = now;
      fall_end_ = std::min(now + kFall, zero_at);
      falls_from_ = passed_;
    }
    if (state_ == State::kFalling && now >= fall_end_) state_ = State::kClosed;
    if (state_ == State::kClosed && !lost && small) {
      state_ = State::kOpen;
      since_ = now;
    }
    passed_ = in_this_state(asked, now);
    return passed_;
  }

 private:
  enum class State { kClosed, kOpen, kFalling };

  static Wrench scaled(const Wrench& w, double factor) noexcept {
    return {vectors::scaled(w.force, factor), vectors::scaled(w.torque, factor)};
  }
  Wrench in_this_state(const Wrench& asked, double now) const noexcept {
    switch (state_) {
      case State::kOpen: return scaled(asked, std::min(1.0, (now - since_) / kRise));
      case State::kFalling: return scaled(falls_from_, (fall_end_ - now) / (fall_end_ - since_));
      case State::kClosed: break;
    }
    return {};
  }

  State state_ = State::kClosed;
  double passed_at_ = -std::numeric_limits<double>::infinity();  ///< Unit: [s].
  double since_ = 0.0, fall_end_ = 0.0;                          ///< of the state. Unit: [s].
  Wrench passed_, falls_from_;
};

/// Stands between what comes over the network and the motors. What show() returns is
///
///  - finite, and within the limits: a larger wrench is scaled down in its direction;
///  - zero before the first wrench, and from kSilence on after the pose that the last wrench answers was
///    measured: where none comes any longer, where they come ever later, and where no pose has gone out;
///  - zero from kFall after the call that first sees a wrench that is not finite, a message that is none, or
///    the loss of the connection;
///  - zero in the first call after show() itself was not called for kSilence;
///  - after any of these, zero until a wrench is small (kGate), and then a share that rises from zero to one
///    within kRise. The program's own gate may not have noticed.
///
/// A drop is a straight line of kFall that begins early enough to end at kSilence: see ForceGate.
///
/// Where local models come, and Limits::damping is known, the force is that of LocalRenderer, and the torque
/// that of the last wrench. A force that is made here is not late, and planes are right for longer than
/// forces: it is zero from kSilence on after the last model came, from kModelAge on after the pose was
/// measured that that answers, and kFall after the handle is farther than kNear from there, or nowhere. All
/// else is as above. Where models begin or cease to have a stiffness, as the force model of the program is
/// changed, the force of the one source falls within kFall, and that of the other comes: of the wrench in
/// LocalRenderer::kSlewTime, of the local model through its gate.
///
/// Has no clock: all times are arguments, in seconds on one clock that never falls. One thread calls take(),
/// take_model() and fail(), one calls show(); nothing here locks, allocates, throws or waits.
class WrenchGovernor {
 public:
  static constexpr double kSilence = ForceGate::kSilence;  ///< Unit: [s].
  static constexpr double kFall = ForceGate::kFall;        ///< Unit: [s].
  static constexpr double kRise = ForceGate::kRise;        ///< Unit: [s].
  static constexpr double kGate = 0.05;                    ///< Share of force_max and of torque_max.
  static constexpr double kModelAge = 0.1;                 ///< Unit: [s].
  /// Over which a ball of 0.1 m is flat to half a millimetre. Unit: [m].
  static constexpr double kNear = 0.01;

  /// \throws std::invalid_argument for limits that are none
  explicit WrenchGovernor(const Limits& limits) : limits_(limits), renderer_(limits) {
    if (!(limits.force_max > 0.0 && std::isfinite(limits.force_max)))
      throw std::invalid_argument("force_max must be above 0 N");
    if (!(limits.torque_max >= 0.0 && std::isfinite(limits.torque_max)))
      throw std::invalid_argument("torque_max must be 0 N m or more");
    if (!(limits.damping >= 0.0 && std::isfinite(limits.damping)))
      throw std::invalid_argument("damping must be 0 N s/m or more");
  }

  /// A wrench came at `t`, as the answer to a pose that was measured at `measured_at`.
  void take(const Wrench& wrench, double measured_at, double t) noexcept {
    if (!vectors::is_finite(wrench.force) || !vectors::is_finite(wrench.torque)) return fail();
    if (!(t - measured_at <= kSilence)) return;  // also where it answers none
    if (t - last_.t > kSilence) ++last_.breaks;
    last_ = {{vectors::clamped(wrench.force, limits_.force_max),
              vectors::clamped(wrench.torque, limits_.torque_max)},
             std::min(measured_at, t),
             true,
             last_.breaks};
    heard_.put(last_);
  }

  /// A local model, likewise.
  void take_model(const LocalModel& model, double measured_at, double t) noexcept {
    if (!is_good(model)) return fail();
    if (!(t - measured_at <= kModelAge)) return;
    if (t > last_model_.zero_at()) ++last_model_.breaks;
    last_model_ = {model, std::min(measured_at, t), t, true, last_model_.breaks};
    models_.put(last_model_);
  }

  /// Something came that is no wrench, or the connection is lost.
  void fail() noexcept {
    last_.good = last_model_.good = false;
    ++last_.breaks;
    ++last_model_.breaks;
    heard_.put(last_);
    models_.put(last_model_);
  }

  /// What the motors shall show at `now`, of the wrenches alone.
  Wrench show(double now) noexcept {
    heard_.update();
    const Heard& heard = heard_.get();
    const bool broken = !heard.good || heard.breaks != breaks_;
    breaks_ = heard.breaks;
    const bool small = is_small(vectors::norm(heard.wrench.force)) &&
                       vectors::norm(heard.wrench.torque) <= kGate * limits_.torque_max;
    return gate_.pass(heard.wrench, small, broken, heard.t + kSilence, now);
  }

  /// What the motors shall show at `now` with the handle at `position`.
  Wrench show(const Vector& position, double now) noexcept {
    Wrench shown = show(now);
    models_.update();
    const HeardModel& heard = models_.get();
    if (limits_.damping == 0.0) return shown;
    const bool local = heard.model.stiffness > 0.0;
    const bool near = vectors::is_place(position) &&
                      vectors::norm(vectors::sum(position, heard.model.position, -1.0)) <= kNear;
    const bool broken = !heard.good || heard.breaks != model_breaks_ || !near || !local;
    model_breaks_ = heard.breaks;
    const Wrench asked{vectors::clamped(renderer_.ask(heard.model, position, now), limits_.force_max), {}};
    // Without a share the program feels nothing, and a model has no planes though the handle may be pressed.
    const bool small = heard.model.share > 0.0 && is_small(renderer_.pressed());
    const Wrench passed = model_gate_.pass(asked, small, broken, heard.zero_at(), now);
    const Vector made = vectors::clamped(passed.force, renderer_.most());
    renderer_.show(made);
    const double remote = remote_share(local, now);
    shown.force = vectors::clamped(vectors::sum(made, shown.force, remote), limits_.force_max);
    return shown;
  }

 private:
  static constexpr double kNever = -std::numeric_limits<double>::infinity();
  struct Heard {
    Wrench wrench;
    double t = kNever;  ///< when the pose was measured that it answers. Unit: [s].
    bool good = false;
    std::uint64_t breaks = 0;  ///< silences and failures so far: show() may be too slow to see each
  };
  struct HeardModel {
    LocalModel model;
    double measured_at = kNever, came = kNever;  ///< Unit: [s].
    bool good = false;
    std::uint64_t breaks = 0;  ///< likewise
    double zero_at() const noexcept { return std::min(came + kSilence, measured_at + kModelAge); }
  };

  bool is_small(double force) const noexcept { return force <= kGate * limits_.force_max; }

  /// The share of the wrench's force that is shown: it goes to zero where the force is made here.
  double remote_share(bool local, double now) noexcept {
    const double passed = std::max(0.0, now - shared_at_);
    shared_at_ = now;
    remote_share_ = local ? std::max(0.0, remote_share_ - passed / kFall)
                          : std::min(1.0, remote_share_ + passed / LocalRenderer::kSlewTime);
    return remote_share_;
  }

  const Limits limits_;
  Heard last_;  ///< the network's thread
  HeardModel last_model_;
  Newest<Heard> heard_;
  Newest<HeardModel> models_;

  // The servo thread.
  ForceGate gate_, model_gate_;
  LocalRenderer renderer_;
  std::uint64_t breaks_ = 0, model_breaks_ = 0;
  double remote_share_ = 1.0;
  double shared_at_ = kNever;  ///< Unit: [s].
};

/// The messages of rosbridge v2 that a client needs.
namespace messages {

using Json = nlohmann::json;

inline constexpr const char* kPose = "/palpate/client/measured_cp";
inline constexpr const char* kWrench = "/palpate/client/servo_cf";
inline constexpr const char* kLocalModel = "/palpate/client/local_model";
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

/// The time that a message is stamped with. Unit: [s].
inline double stamp_of(const Json& message) {
  const Json& stamp = at(at(message, "header"), "stamp");
  return number(at(stamp, "secs")) + number(at(stamp, "nsecs")) / kBillion;
}

/// A WrenchStamped; NaN for what is missing.
inline Wrench wrench(const Json& message) {
  const Json& wrench = at(message, "wrench");
  return {vector3(at(wrench, "force")), vector3(at(wrench, "torque"))};
}

/// A palpate/LocalModel; NaN for what is missing, and a count of kMost + 1 for planes that are none.
inline LocalModel local_model(const Json& message) {
  LocalModel model;
  model.position = vector3(at(message, "position"));
  const Json& planes = at(message, "planes");
  model.count = planes.is_array() ? planes.size() : LocalModel::kMost + 1;
  if (model.count <= LocalModel::kMost) {
    for (std::size_t k = 0; k < model.count; ++k)
      model.planes[k] = {vector3(at(planes[k], "point")), vector3(at(planes[k], "normal"))};
  }
  model.stiffness = number(at(message, "stiffness"));
  model.damping = number(at(message, "damping"));
  model.friction = number(at(message, "friction"));
  model.share = number(at(message, "share"));
  return model;
}

/// Of the numbers of PREFIX/palpate/local_model, which docs/ros.md lists: when the pose was measured, on the
/// clock that poses are stamped with. NaN for what is missing. Unit: [s].
inline double measured_at(const std::vector<double>& numbers) {
  return numbers.size() < 2 ? std::numeric_limits<double>::quiet_NaN() : numbers[0] + numbers[1] / kBillion;
}

/// The model in them; one that is_good() refuses for numbers that are none.
inline LocalModel local_model(const std::vector<double>& numbers) {
  constexpr std::size_t kHead = 9, kPlane = 6;
  LocalModel model;
  model.count = LocalModel::kMost + 1;
  if (numbers.size() < kHead || (numbers.size() - kHead) % kPlane != 0) return model;
  model.count = (numbers.size() - kHead) / kPlane;
  model.position = {numbers[2], numbers[3], numbers[4]};
  model.stiffness = numbers[5];
  model.damping = numbers[6];
  model.friction = numbers[7];
  model.share = numbers[8];
  for (std::size_t k = 0; k < std::min(model.count, LocalModel::kMost); ++k) {
    const double* const plane = numbers.data() + kHead + kPlane * k;
    model.planes[k] = {{plane[0], plane[1], plane[2]}, {plane[3], plane[4], plane[5]}};
  }
  return model;
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
      : governor_(limits), local_(limits.damping > 0.0), ready_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
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
  /// The same with the handle at `position`, of the local model where Limits::damping is known: then 1000
  /// times a second, and with each position that is sent. Unit: [m].
  Wrench wrench(const Vector& position) noexcept { return governor_.show(position, now()); }

  /// How many wrenches have come so far. Any thread.
  std::uint64_t wrench_count() const noexcept { return wrench_count_; }
  /// When the pose was measured that the newest wrench answers; 0 before the first. Any thread. Unit: [s].
  double answered() const noexcept { return answered_; }

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
    std::vector<const char*> topics{messages::kWrench, messages::kEcho};
    if (local_) topics.push_back(messages::kLocalModel);
    for (const char* topic : topics) {
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
    const double measured_at = messages::stamp_of(content);
    if (at(message, "topic") == messages::kLocalModel)
      return governor_.take_model(messages::local_model(content), measured_at, t);
    if (at(message, "topic") != messages::kWrench) return governor_.fail();
    governor_.take(messages::wrench(content), measured_at, t);
    answered_.store(measured_at, std::memory_order_relaxed);
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
  bool local_;  ///< models are wanted
  Newest<TimedPose> poses_;
  int ready_;  ///< an eventfd: how the servo thread wakes the network's without a lock
  std::atomic<bool> connected_ = false;
  std::atomic<std::uint64_t> wrench_count_ = 0;
  std::atomic<double> answered_ = 0.0;  ///< Unit: [s].
  std::unique_ptr<Connection> connection_;
};

}  // namespace palpate_client

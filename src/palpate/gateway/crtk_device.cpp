#include <palpate/gateway/crtk_device.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/base/real_time.h>
#include <palpate/geometry/rotation.h>
#include <palpate/servo/safety_governor.h>

namespace palpate {
namespace {

/// Largest deviation of a quaternion's norm from 1: more than drivers in single precision leave.
constexpr double kNotUnit = 1e-2;
/// Largest distance of a pose from the origin; beyond it is an error. Unit: [m].
constexpr double kFarthest = 1e6;
/// Interval of echo requests. Unit: [s].
constexpr double kEchoPeriod = 0.1;
/// Age up to which a received velocity is used instead of differences of poses. Unit: [s].
constexpr double kVelocityAge = 0.02;
/// Time within which the force ramps to zero after a stale pose (FaultTraits::fall_time). Unit: [s].
constexpr double kFall = 0.03;

bool is_finite(const Pose& pose) {
  return pose.position.allFinite() && pose.orientation.coeffs().allFinite() &&
         pose.position.norm() <= kFarthest;
}

/// Transports can return only stamps of which this holds.
bool is_stamp(double seconds) { return std::isfinite(seconds) && seconds >= 0.0; }

bool is_unit(const Eigen::Quaterniond& q) { return std::abs(q.norm() - 1.0) <= kNotUnit; }

/// Names of the devices that this process has open: two hands on one device would feel the sum of two forces,
/// and publishers of one process look like one to the network.
class OpenNames {
 public:
  /// \returns false if the name is there already
  bool insert(const std::string& name) {
    const std::scoped_lock lock(mutex_);
    return names_.insert(name).second;
  }
  void erase(const std::string& name) {
    const std::scoped_lock lock(mutex_);
    names_.erase(name);
  }

 private:
  std::mutex mutex_;
  std::set<std::string> names_;
};

OpenNames& open_names() {
  static OpenNames names;
  return names;
}

}  // namespace

CrtkDevice::CrtkDevice(CrtkOptions options, std::unique_ptr<CrtkTransport> transport)
    : options_(std::move(options)),
      age_limit_(SafetyLimits::of(options_.capabilities, SafetyLimits().tick).stale_after),
      transport_(std::move(transport)),
      stamps_(options_.one_way, age_limit_),
      reader_(options_.capabilities, hand_) {
  const std::string& name = options_.capabilities.name;
  if (!(options_.extrapolation >= 0.0 && options_.extrapolation <= CrtkOptions::kMostExtrapolation))
    throw Error("device '{}': extrapolation must be 0 to {} s", name, CrtkOptions::kMostExtrapolation);
  if (!(options_.one_way >= 0.0 && options_.one_way < age_limit_))
    throw Error("device '{}': the one-way delay must be 0 to {} s", name, age_limit_);
  // An extrapolated pose looks newer than its measurement by up to that time.
  options_.capabilities.delay += options_.extrapolation;
  if (!options_.frame.empty()) frame_ = options_.frame;
  said_at_.fill(-2.0 * kSilence);
}

void CrtkDevice::open() {
  if (status() != DeviceStatus::kClosed)
    throw Error("device '{}': is open already; close it first", options_.capabilities.name);
  if (!open_names().insert(options_.capabilities.name))
    throw Error("device '{}': another hand of this program uses it; give each hand a device of its own",
                options_.capabilities.name);
  try {
    transport_->start(*this);
  } catch (...) {
    open_names().erase(options_.capabilities.name);
    throw;
  }
  set_status(DeviceStatus::kOpen);
}

void CrtkDevice::enable() {
  if (status() != DeviceStatus::kOpen)
    throw Error("device '{}': is not open; open it first", options_.capabilities.name);
  read_ = came_back_ = said_alone_ = false;
  has_listener_.store(transport_->has_listener(), std::memory_order_relaxed);
  known_ = transport_->arrivals();
  arrivals_.store(known_, std::memory_order_relaxed);
  alone_since_ = monotonic_now();
  good_at_ = told_ = 0.0;
  begin_ = std::numeric_limits<double>::infinity();
  stopped_.store(true, std::memory_order_relaxed);
  ends_.store(false, std::memory_order_relaxed);
  set_status(DeviceStatus::kEnabled);
  sender_ = std::thread([this] { send_until_closed(); });
}

void CrtkDevice::close() noexcept {
  stop();
  ends_.store(true, std::memory_order_relaxed);
  written_.set();
  if (sender_.joinable()) sender_.join();
  if (status() == DeviceStatus::kClosed) return;
  transport_->stop();
  open_names().erase(options_.capabilities.name);
  set_status(DeviceStatus::kClosed);
}

void CrtkDevice::stop() noexcept {
  stopped_.store(true, std::memory_order_relaxed);
  written_.set();
}

/// Sends every written wrench, or only the newest if the transport is slower; once stopped, a zero wrench.
/// At normal priority: where readers lack the time for every wrench, more of them would take it from the
/// driver.
void CrtkDevice::send_until_closed() {
  name_thread("palpate-sender");
  double echoed = 0.0;
  bool off = true;  // the stop was sent
  while (!ends_.load(std::memory_order_relaxed)) {
    written_.wait(kEchoPeriod);
    if (const double now = monotonic_now(); now - echoed >= kEchoPeriod) {
      echoed = now;
      transport_->send_echo(ask_echo(now));
      look_for_listener(now);
    }
    const bool fresh = wrench_.update(), stopped = stopped_.load(std::memory_order_relaxed);
    const bool shows = surface_.update();
    const std::uint64_t arrivals = look_for_arrival();
    if (shows) send_surface(stopped || surface_.front().known != arrivals);
    if (!fresh && (off || !stopped)) continue;
    auto [wrench, known] = wrench_.front();
    // The loop has yet to hear of whoever came after it wrote this.
    if (stopped || known != arrivals) wrench.spatial = wrench.body = {};
    send(wrench);
    off = stopped;
  }
  CrtkWrench none;
  none.stamp = wrench_.front().wrench.stamp;
  send(none);
  if (wants_local_model_.load(std::memory_order_relaxed)) send_surface(true);
}

/// Looked at before every wrench: at the next look for listeners, who came in contact would have been pushed
/// for up to kEchoPeriod.
std::uint64_t CrtkDevice::look_for_arrival() {
  const std::uint64_t arrivals = transport_->arrivals();
  if (arrivals != arrivals_.exchange(arrivals, std::memory_order_relaxed)) look_for_listener(monotonic_now());
  return arrivals;
}

void CrtkDevice::look_for_listener(double now) {
  const bool wants = transport_->wants_local_model(), listens = transport_->has_listener() || wants;
  wants_local_model_.store(wants, std::memory_order_relaxed);
  has_listener_.store(listens, std::memory_order_relaxed);
  if (listens || now - heard_ >= kSilence) {
    alone_since_ = now;
    said_alone_ = false;
  } else if (!said_alone_ && now - alone_since_ >= kDiscovery) {
    said_alone_ = true;
    say(fmt::format(
        "{}: poses arrive, but nothing subscribes to spatial/servo_cf or body/servo_cf: no force until a "
        "driver does; check the names of its topics",
        options_.capabilities.name));
  }
}

void CrtkDevice::send(const CrtkWrench& wrench) {
  std::string frame;
  {
    const std::scoped_lock lock(mutex_);
    frame = frame_.value_or("");
  }
  transport_->send(wrench, frame);
}

void CrtkDevice::send_surface(bool stopped) {
  auto [model, stamp, known] = surface_.front();
  if (stopped) model.share = 0.0;
  transport_->send_local_model(model, stamp);
}

std::uint64_t CrtkDevice::ask_echo(double now) {
  const std::scoped_lock lock(mutex_);
  return stamps_.echoes().ask(now);
}

bool CrtkDevice::is_other_source(std::string_view source, double now) {
  return taken_ > 0 && source != source_ && now - heard_ < kSilence;
}

/// \param anew from another publisher than the last pose, and so on another clock
CrtkDevice::Problem CrtkDevice::check_stamp(const CrtkHeader& header, bool anew, double now) {
  age_ = 0.0;
  if (header.stamp == 0.0) return Problem::kNone;  // without a stamp, the pose counts as new
  StampClock::Check check;
  {
    const std::scoped_lock lock(mutex_);
    if (anew) stamps_.reset();
    check = stamps_.check(header.stamp, now);
  }
  if (check.clock_set)
    say(fmt::format("{}: the clock of '{}' was set; its latency is taken to be {:.1f} ms",
                    options_.capabilities.name, header.source, 1e3 * options_.one_way));
  age_ = check.age;
  if (check.other_clock) return Problem::kOtherClock;
  switch (check.verdict) {
    case StampClock::Verdict::kLate: return Problem::kStale;
    case StampClock::Verdict::kFuture: return Problem::kFuture;
    default: return Problem::kNone;
  }
}

void CrtkDevice::set_other_writer(std::string_view name) {
  const std::scoped_lock lock(mutex_);
  other_writer_ = name;
}

std::string CrtkDevice::other_writer() const {
  const std::scoped_lock lock(mutex_);
  return other_writer_;
}

CrtkDevice::Problem CrtkDevice::problem_of(const CrtkHeader& header, const Pose& pose, double now) {
  if (!other_writer().empty()) return Problem::kWriter;
  if (is_other_source(header.source, now)) return Problem::kSecond;
  const bool anew = taken_ > 0 && header.source != source_;
  const bool any_frame = !frame_ || (anew && options_.frame.empty());
  if (!any_frame && header.frame != *frame_) return Problem::kFrame;
  if (!is_finite(pose) || !is_unit(pose.orientation)) return Problem::kBad;
  if (!is_stamp(header.stamp)) return Problem::kStamp;
  return check_stamp(header, anew, now);
}

void CrtkDevice::take_pose(const CrtkHeader& header, const Pose& pose) {
  const double t = monotonic_now();
  const Problem problem = problem_of(header, pose, t);
  if (problem != Problem::kNone) return refuse(problem, header, t);
  if (header.source != source_) {
    if (taken_ > 0) hand_.change_hand();
    source_ = header.source;
  } else if (t - heard_ > age_limit_ && taken_ > 0) {
    hand_.change_hand();
  }
  if (frame_ != header.frame) {
    const std::scoped_lock lock(mutex_);
    frame_ = header.frame;
  }
  accept(pose, header.stamp, t);
}

void CrtkDevice::accept(const Pose& pose, double stamp, double now) {
  Pose unit = pose;
  unit.orientation.normalize();
  stamp_of_[(taken_ + 1) % stamp_of_.size()].store(stamp, std::memory_order_relaxed);
  ++taken_;
  hand_.put(DevicePose(unit), now - age_);
  heard_ = now;
  reason_.store(Problem::kNone, std::memory_order_relaxed);
}

void CrtkDevice::refuse(Problem problem, const CrtkHeader& header, double now) {
  ++dropped_;
  if (problem == Problem::kBad) hand_.change_hand();
  if (problem != Problem::kSecond) reason_.store(problem, std::memory_order_relaxed);
  double& told = said_at_[static_cast<std::size_t>(problem)];
  if (now - std::exchange(told, now) >= kSilence) say(line_of(problem, header));
}

/// Names of frames and of other programs come from the network.
void CrtkDevice::say(const std::string& line) const { transport_->say(message_line(line)); }

std::string CrtkDevice::line_of(Problem problem, const CrtkHeader& header) const {
  std::string who = fmt::format("{}: poses of '{}'", options_.capabilities.name, header.source);
  switch (problem) {
    case Problem::kBad:
      return who +
             " are not finite or their quaternion is not of unit norm: no force until valid poses arrive; "
             "correct the driver";
    case Problem::kStamp: return who + " have invalid stamps and are dropped; correct the driver";
    case Problem::kFrame:
      return fmt::format(
          "{} are in the frame '{}', not '{}', and are dropped; set the driver's frame_id{}", who,
          header.frame, *frame_,
          options_.frame.empty() ? " or, if it is another one now, restart Palpate" : " or the option frame");
    case Problem::kStale:
      return fmt::format(
          "{} are late, repeated or out of order (age limit {:.0f} ms) and are dropped; if this persists, "
          "shorten the latency or, if the driver's clock was set, restart Palpate",
          who, 1e3 * age_limit_);
    case Problem::kFuture:
      return who +
             " have stamps in the future and are dropped; if the clock was set, they are accepted after a "
             "second";
    case Problem::kOtherClock:
      return who +
             " are stamped by another clock than its answers to echoes, and are dropped; unless the clock "
             "was "
             "just set, answer echoes with the clock of the poses";
    case Problem::kSecond:
      return fmt::format(
          "{} are dropped: '{}' controls the device until it is silent for {:.0f} s; stop one of the "
          "publishers",
          who, source_, kSilence);
    case Problem::kWriter:
      return fmt::format(
          "{}: '{}' publishes wrenches for the device, too: no force until it has ended; stop "
          "one of the two",
          options_.capabilities.name, other_writer());
    default: return who;
  }
}

void CrtkDevice::take_velocity(const CrtkHeader& header, const Twist& twist) {
  if (header.source != source_ || !twist.linear.allFinite() || !twist.angular.allFinite()) return;
  velocity_.back() = twist;
  velocity_.publish();
  velocity_at_.store(monotonic_now(), std::memory_order_relaxed);
}

void CrtkDevice::take_echo(std::uint64_t number, const CrtkHeader& header) {
  if (header.source != source_ || !is_stamp(header.stamp)) return;
  const std::scoped_lock lock(mutex_);
  stamps_.echoes().answer(number, header.stamp, monotonic_now());
}

/// Returns monotonic_now() at the loop's time 0. A tick begins slightly before this call, so that the least
/// difference is the best estimate.
double CrtkDevice::loop_begin(double t) {
  begin_ = std::min(begin_, monotonic_now() - t);
  return begin_;
}

bool CrtkDevice::extrapolate(double t, DeviceReading& reading) {
  if (!read_ || status() != DeviceStatus::kEnabled) return false;
  const double carried = std::min(t - last_.t, options_.extrapolation);
  if (!(last_.t + carried > told_)) return false;
  DeviceReading next = last_;
  next.t = told_ = last_.t + carried;
  next.pose.position += carried * last_.velocity.linear;
  const Eigen::Vector3d turn = carried * last_.velocity.angular;
  if (const double angle = turn.norm(); angle > 0.0)
    next.pose.orientation = Eigen::AngleAxisd(angle, turn / angle) * last_.pose.orientation;
  reading = next;
  return true;
}

bool CrtkDevice::read(double t, DeviceReading& reading) {
  constexpr double kAfter = 1e-6;  // s, step past an extrapolated reading that is later than this one
  const double begin = loop_begin(t);
  velocity_.update();
  if (reader_.read(t, last_)) {
    // The governor's start gate takes whoever comes to listen as another hand.
    last_.hand += static_cast<std::uint32_t>(arrivals_.load(std::memory_order_relaxed));
    read_ = true;
    good_at_ = t;
    last_.t = std::min(last_.t - begin, t);
    if (t + begin - velocity_at_.load(std::memory_order_relaxed) < kVelocityAge)
      last_.velocity = velocity_.front();
    if (status() == DeviceStatus::kFault) {
      came_back_ = true;
      set_status(DeviceStatus::kEnabled);
    }
    reading = last_;
    reading.t = told_ = std::max(last_.t, std::min(told_ + kAfter, t));
    return true;
  }
  if (t - good_at_ > age_limit_ + kFall && status() == DeviceStatus::kEnabled) {
    constexpr std::array<const char*, static_cast<std::size_t>(Problem::kCount)> kTexts{
        "no poses received",
        "poses are not finite or their quaternion is not of unit norm",
        "poses have invalid stamps",
        "poses have a wrong frame_id",
        "poses are late or out of order",
        "pose stamps are in the future",
        "poses are stamped by another clock than echoes",
        "two publishers of poses",
        "another program publishes wrenches for the device"};
    set_status(DeviceStatus::kFault,
               kTexts[static_cast<std::size_t>(reason_.load(std::memory_order_relaxed))]);
  }
  return extrapolate(t, reading);
}

void CrtkDevice::write(const Wrench& wrench) {
  if (status() == DeviceStatus::kClosed || status() == DeviceStatus::kOpen) return;
  if (wrench.force.isZero(0.0) && wrench.torque.isZero(0.0)) came_back_ = false;
  const std::uint64_t arrivals = arrivals_.load(std::memory_order_relaxed);
  if (!has_listener() || arrivals != known_) came_back_ = true;
  known_ = arrivals;
  shows_ = status() == DeviceStatus::kEnabled && !came_back_;
  auto& [out, known] = wrench_.back();
  known = known_;
  out.spatial = shows_ ? wrench : Wrench{};
  const Eigen::Quaterniond back = last_.pose.orientation.conjugate();
  out.body = {back * out.spatial.force, back * out.spatial.torque};
  out.stamp = answered_ = stamp_of_[hand_.seen() % stamp_of_.size()].load(std::memory_order_relaxed);
  stopped_.store(false, std::memory_order_relaxed);
  wrench_.publish();
  written_.set();
}

void CrtkDevice::see(const TickRecord& record, const TickTimes&) {
  if (!wants_local_model_.load(std::memory_order_relaxed)) return;
  auto& [model, stamp, known] = surface_.back();
  known = known_;
  model = local_model_of(record);
  if (!shows_) model.share = 0.0;
  stamp = answered_;
  surface_.publish();
  written_.set();
}

}  // namespace palpate

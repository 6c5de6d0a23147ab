/// \file
/// Haptic device whose driver speaks CRTK over a network, independent of the transport.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include <palpate/base/triple_buffer.h>
#include <palpate/gateway/client_hand.h>
#include <palpate/gateway/local_model.h>
#include <palpate/gateway/stamp_clock.h>
#include <palpate/servo/haptic_device.h>
#include <palpate/servo/servo_loop.h>

namespace palpate {

class CrtkDevice;

/// Header of a received `measured_cp` or `measured_cv`.
struct CrtkHeader {
  double stamp = 0.0;       ///< of the message, on the publisher's clock; 0: none; NaN: invalid. Unit: [s].
  std::string_view frame;   ///< frame_id
  std::string_view source;  ///< the publisher: a node's name, a writer's GUID
};

/// A `servo_cf`, in the device's frame.
struct CrtkWrench {
  Wrench spatial;      ///< expressed in the device's base frame
  Wrench body;         ///< expressed in the handle's frame
  double stamp = 0.0;  ///< of the pose it answers, on the publisher's clock. Unit: [s].
};

/// Message transport: ROS 1, DDS, or a test. Calls CrtkDevice::take_*() from one thread at a time.
class CrtkTransport {
 public:
  CrtkTransport() = default;
  virtual ~CrtkTransport() = default;
  CrtkTransport(const CrtkTransport&) = delete;
  CrtkTransport& operator=(const CrtkTransport&) = delete;

  /// Starts delivering messages to `device`, even if there is no peer yet. Must not wait for one. \throws
  /// Error
  virtual void start(CrtkDevice& device) = 0;
  /// Stops delivery. No message is delivered after it returns.
  virtual void stop() noexcept = 0;
  /// Returns whether a topic of wrenches has subscribers. Polled by the device's own thread, and by enable()
  /// before that runs.
  virtual bool has_listener() = 0;
  /// Returns a number that grows with every subscriber of the wrenches or the local model that comes, also if
  /// another leaves at the same time. Called before every wrench, on the device's own thread, and by enable()
  /// before that runs.
  virtual std::uint64_t arrivals() = 0;
  /// Publishes a wrench; called for every tick, on the device's own thread. \param frame frame_id of valid
  /// poses, that of `wrench.spatial`; empty if it is not known yet
  virtual void send(const CrtkWrench& wrench, const std::string& frame) = 0;
  /// Returns whether the local model has subscribers. Polled by the device's own thread.
  virtual bool wants_local_model() = 0;
  /// Publishes the local model, if it has subscribers; called for every tick, on the device's own thread.
  /// \param stamp as of the wrench
  virtual void send_local_model(const LocalModel& model, double stamp) = 0;
  /// Requests an echo of the publisher's time, to be answered through CrtkDevice::take_echo() with the same
  /// number.
  virtual void send_echo(std::uint64_t number) = 0;
  /// Shows one line, which is printable, to the user. Any thread except the loop's.
  virtual void say(const std::string& line) = 0;
};

/// Properties of a CRTK device known in advance.
struct CrtkOptions {
  /// The rate is the minimum rate of poses: the age limit is three periods, at least 20 ms. Without a pose
  /// for that long there is no force, and a pose that is older on arrival is dropped.
  DeviceCapabilities capabilities;
  /// Expected frame_id of poses; empty: that of the publisher's first accepted pose, and so another one once
  /// another publisher has taken over.
  std::string frame;
  double one_way = 5e-4;  ///< as for StampClock, if echoes are not answered. Unit: [s].
  /// Maximum extrapolation of a pose by its velocity when the next is late; 0: none. Counted as delay. Unit:
  /// [s], at most kMostExtrapolation.
  double extrapolation = 0.0;

  static constexpr double kMostExtrapolation = 0.01;
};

/// Haptic device at the far end of a network: it sends stamped poses and receives a wrench with every tick.
///
/// Messages are checked on arrival. Each problem is reported once, through CrtkTransport::say(), and again
/// only after a second without it:
///
///  - A stamp that is older than the last (reordering, duplicates) or than the age limit, or of the future:
///    dropped.
///  - An invalid or negative stamp: dropped.
///  - A stamp of another clock than the one that answers echoes: dropped.
///  - Another frame_id than expected: dropped.
///  - A second publisher: dropped, until the first has been silent for kSilence. It takes over through the
///    start gate, with its own clock and, unless CrtkOptions::frame tells it, its own frame_id.
///  - A pose while another program publishes wrenches for the device: dropped, since the sum of two forces
///    has no limit, and neither program can stop the other's.
///  - NaN, infinity, a quaternion that is not of unit norm: dropped, and no force until it returns through
///    the gate.
///
/// Without a valid pose for the age limit, the governor's stale-pose fault ramps the force to zero, and the
/// status then becomes kFault with the reason. Valid poses clear the fault automatically, through the start
/// gate. Late poses stay dropped however long they are late: nothing but echoes, another publisher, or a
/// clock that was set (StampClock) makes them valid, and the latter is reported.
///
/// Whoever subscribes to the wrenches or the local model in contact gets no step: all subscribers get zero
/// wrenches from then on, until the force returns through the start gate. What subscribes is not known to be
/// a driver; a tool that shows the wrenches interrupts the force all the same. While nothing subscribes, zero
/// wrenches are sent, too; this is reported if poses have arrived for kDiscovery.
class CrtkDevice final : public HapticDevice, public TickObserver {
 public:
  /// \throws Error if the extrapolation is too long.
  CrtkDevice(CrtkOptions options, std::unique_ptr<CrtkTransport> transport);
  ~CrtkDevice() override { close(); }

  void open() override;
  void enable() override;
  void close() noexcept override;
  const DeviceCapabilities& capabilities() const override { return options_.capabilities; }
  bool read(double t, DeviceReading& reading) override;
  void wait(const LoopClock& clock, double until) override { reader_.wait(clock, until); }
  void write(const Wrench& wrench) override;
  void stop() noexcept override;
  /// Observer of its own loop: publishes the surface around the handle to subscribers.
  void see(const TickRecord& record, const TickTimes& times) override;

  /// \name The transport's thread
  /// @{
  void take_pose(const CrtkHeader& header, const Pose& pose);
  /// Velocity of the handle, used instead of differences of poses while it is received.
  void take_velocity(const CrtkHeader& header, const Twist& twist);
  /// Answer to an echo. Only answers of the active publisher are used. \param header its stamp is the
  /// publisher's time when it answered
  void take_echo(std::uint64_t number, const CrtkHeader& header);
  /// @}

  /// Tells which other program publishes wrenches for the device. \param name empty: none. Any thread except
  /// the loop's.
  void set_other_writer(std::string_view name);

  /// Returns whether anything subscribes to the wrenches or the local model. Any thread.
  bool has_listener() const { return has_listener_.load(std::memory_order_relaxed); }

  /// Number of poses used and dropped. Any thread.
  std::uint64_t taken() const { return taken_.load(std::memory_order_relaxed); }
  std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

  /// Silence of a publisher after which another publisher is accepted. Unit: [s].
  static constexpr double kSilence = 1.0;
  /// Time that a driver has to subscribe to the wrenches. Unit: [s].
  static constexpr double kDiscovery = 2.0;

 private:
  enum class Problem : std::uint8_t {
    kNone,
    kBad,
    kStamp,
    kFrame,
    kStale,
    kFuture,
    kOtherClock,
    kSecond,
    kWriter,
    kCount
  };

  std::string other_writer() const;
  Problem problem_of(const CrtkHeader& header, const Pose& pose, double now);
  bool is_other_source(std::string_view source, double now);
  Problem check_stamp(const CrtkHeader& header, bool anew, double now);
  void refuse(Problem problem, const CrtkHeader& header, double now);
  std::string line_of(Problem problem, const CrtkHeader& header) const;
  void say(const std::string& line) const;
  void accept(const Pose& pose, double stamp, double now);
  void send_until_closed();
  void look_for_listener(double now);
  std::uint64_t look_for_arrival();
  void send(const CrtkWrench& wrench);
  void send_surface(bool stopped);
  bool extrapolate(double t, DeviceReading& reading);
  double loop_begin(double t);
  std::uint64_t ask_echo(double now);

  CrtkOptions options_;
  double age_limit_;  ///< Unit: [s].
  std::unique_ptr<CrtkTransport> transport_;

  /// \name The transport's thread
  /// Times are monotonic_now()'s.
  /// @{
  ClientHand hand_;
  StampClock stamps_;
  std::optional<std::string> frame_;  ///< expected; unset until a pose has been accepted
  std::string source_;
  double age_ = 0.0;                       ///< of the pose being checked
  std::atomic<double> heard_ = -kSilence;  ///< arrival of the last valid pose. Unit: [s].
  std::array<double, static_cast<std::size_t>(Problem::kCount)> said_at_{};  ///< last occurrence of each
  std::atomic<std::uint64_t> taken_ = 0, dropped_ = 0;
  std::array<std::atomic<double>, 256> stamp_of_{};  ///< indexed by the number of the pose, modulo 256
  TripleBuffer<Twist> velocity_;
  std::atomic<double> velocity_at_ = -kSilence;
  /// @}

  mutable std::mutex mutex_;  ///< guards stamps_, changes of frame_, and other_writer_
  std::string other_writer_;
  /// \name The loop's thread
  /// @{
  ClientDevice reader_;
  DeviceReading last_;  ///< as measured, on the loop's clock
  double told_ = 0.0;   ///< DeviceReading::t of the last reading. Unit: [s].
  bool read_ = false, came_back_ = false, shows_ = false;
  double good_at_ = 0.0;     ///< Unit: [s].
  double answered_ = 0.0;    ///< stamp of the pose that the last wrench answers. Unit: [s].
  double begin_ = 0.0;       ///< monotonic_now() at the loop's 0, at most this. Unit: [s].
  std::uint64_t known_ = 0;  ///< arrivals_ at the last wrench
  struct Written {
    CrtkWrench wrench;
    std::uint64_t known = 0;
  };
  TripleBuffer<Written> wrench_;
  struct Surface {
    LocalModel model;
    double stamp = 0.0;  ///< of the pose it answers, on the publisher's clock. Unit: [s].
    std::uint64_t known = 0;
  };
  TripleBuffer<Surface> surface_;
  /// @}
  /// \name The device's own thread
  /// @{
  double alone_since_ = 0.0;  ///< since when poses have arrived without a listener. Unit: [s].
  bool said_alone_ = false;
  /// @}
  std::atomic<bool> wants_local_model_ = false, has_listener_ = false;
  std::atomic<std::uint64_t> arrivals_ = 0;  ///< CrtkTransport::arrivals()
  std::atomic<bool> stopped_ = true, ends_ = true;
  std::atomic<Problem> reason_ = Problem::kNone;
  Wake written_;
  std::thread sender_;
};

}  // namespace palpate

/// \file
/// A device whose driver speaks CRTK over a network, whatever carries the messages.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
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

/// A `measured_cp` or `measured_cv` as it came.
struct CrtkHeader {
  double stamp = 0.0;       ///< of the message, on the publisher's clock; 0: none. Unit: [s].
  std::string_view frame;   ///< frame_id
  std::string_view source;  ///< the publisher: a node's name, a writer's GUID
};

/// A `servo_cf`, the device's frame.
struct CrtkWrench {
  Wrench spatial;      ///< along the axes of the device's base
  Wrench body;         ///< along those of the handle
  double stamp = 0.0;  ///< of the pose it answers, on the publisher's clock. Unit: [s].
};

/// What carries messages: ROS 1, DDS, a test. It calls CrtkDevice::take_*() from one thread at a time.
class CrtkTransport {
 public:
  CrtkTransport() = default;
  virtual ~CrtkTransport() = default;
  CrtkTransport(const CrtkTransport&) = delete;
  CrtkTransport& operator=(const CrtkTransport&) = delete;

  /// Begins to hand messages to `device`, also if no peer is there yet. Must not wait for one. \throws Error
  virtual void start(CrtkDevice& device) = 0;
  /// Nothing is handed over after it returns.
  virtual void stop() noexcept = 0;
  /// Publishes; called for every tick, by the device's own thread.
  virtual void send(const CrtkWrench& wrench) = 0;
  /// Whether anybody gets send_local_model(). Asked now and then by the device's own thread.
  virtual bool wants_local_model() = 0;
  /// Publishes, where it is wanted; called for every tick, by the device's own thread. \param stamp as of the
  /// wrench
  virtual void send_local_model(const LocalModel& model, double stamp) = 0;
  /// Asks the publisher for the time: to be answered by CrtkDevice::take_echo() with the same number.
  virtual void send_echo(std::uint64_t number) = 0;
  /// One line for a person. Any thread but the loop's.
  virtual void say(const std::string& line) = 0;
};

/// What is known of a device beforehand.
struct CrtkOptions {
  /// Whose rate says how often poses come at least: without three of them (and at least 20 ms) there is no
  /// force. A pose that is older when it comes is dropped.
  DeviceCapabilities capabilities;
  std::string frame;      ///< frame_id of poses; empty: that of the first
  double one_way = 5e-4;  ///< StampClock's, where no echo is answered. Unit: [s].
  /// How far a pose is carried on by its velocity where the next is late; 0: not at all. Counted as delay.
  /// Unit: [s], at most kMostExtrapolation.
  double extrapolation = 0.0;

  static constexpr double kMostExtrapolation = 0.01;
};

/// A device at the other end of a network: its poses come with stamps, wrenches go back with every tick.
///
/// What comes is checked where it arrives, and what is wrong with it is said once, through
/// CrtkTransport::say(), and again only after a second without it:
///
///  - A stamp that is older than the last (reordering, duplicates) or than the age limit, or of the future:
///    dropped.
///  - Another frame_id than expected: dropped.
///  - A second publisher: dropped, until the first has been silent for kSilence.
///  - NaN, infinity, a quaternion that is not of unit norm: dropped, and no force until it comes back through
///    the gate.
///
/// Where nothing good comes for the age limit, the governor's stale-pose lets the force fall to zero, and the
/// status becomes kFault with the reason once it has fallen. Good poses end that by themselves, through the
/// gate. A publisher whose clock was set is believed after kSilence.
class CrtkDevice final : public HapticDevice, public TickObserver {
 public:
  /// \throws Error for an extrapolation that is too long.
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
  /// Of its own loop: the surface about the handle goes to who wants it.
  void see(const TickRecord& record, const TickTimes& times) override;

  /// \name The transport's thread
  /// @{
  void take_pose(const CrtkHeader& header, const Pose& pose);
  /// Velocity of the handle, used in place of differences of poses while it comes.
  void take_velocity(const CrtkHeader& header, const Twist& twist);
  /// Of whose poses are felt; another's clock tells nothing of theirs. \param header its stamp is the
  /// publisher's clock when it answered
  void take_echo(std::uint64_t number, const CrtkHeader& header);
  /// @}

  /// Poses that were felt, and that were dropped. Any thread.
  std::uint64_t taken() const { return taken_.load(std::memory_order_relaxed); }
  std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

  /// Of a publisher, after which another's poses are felt. Unit: [s].
  static constexpr double kSilence = 1.0;

 private:
  enum class Problem : std::uint8_t { kNone, kBad, kFrame, kStale, kFuture, kSecond, kCount };

  Problem problem_of(const CrtkHeader& header, const Pose& pose, double now);
  bool is_other_source(std::string_view source, double now);
  Problem check_stamp(double stamp, bool anew, double now);
  void refuse(Problem problem, const CrtkHeader& header, double now);
  std::string line_of(Problem problem, const CrtkHeader& header) const;
  void accept(const Pose& pose, double stamp, double now);
  void send_until_closed();
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
  std::string frame_, source_;
  double stamp_ = 0.0;        ///< newest that was taken, the publisher's clock. Unit: [s].
  double age_ = 0.0;          ///< of the pose that is looked at
  double heard_ = -kSilence;  ///< when a good pose came last. Unit: [s].
  double refused_since_ = std::numeric_limits<double>::infinity();  ///< nothing good has come. Unit: [s].
  std::array<double, static_cast<std::size_t>(Problem::kCount)> said_at_{};  ///< when each came last
  std::atomic<std::uint64_t> taken_ = 0, dropped_ = 0;
  std::array<std::atomic<double>, 256> stamp_of_{};  ///< by number of the pose
  TripleBuffer<Twist> velocity_;
  std::atomic<double> velocity_at_ = -kSilence;
  /// @}

  std::mutex mutex_;  ///< of ClientClock: sender and transport
  /// \name The loop's thread
  /// @{
  ClientDevice reader_;
  DeviceReading last_;  ///< as measured, on the loop's clock
  double told_ = 0.0;   ///< DeviceReading::t of the last one. Unit: [s].
  bool read_ = false, came_back_ = false, shows_ = false;
  double good_at_ = 0.0;   ///< Unit: [s].
  double answered_ = 0.0;  ///< stamp of the pose that the last wrench answers. Unit: [s].
  double begin_ = 0.0;     ///< monotonic_now() at the loop's 0, at most this. Unit: [s].
  TripleBuffer<CrtkWrench> wrench_;
  struct Surface {
    LocalModel model;
    double stamp = 0.0;  ///< of the pose it answers, on the publisher's clock. Unit: [s].
  };
  TripleBuffer<Surface> surface_;
  /// @}
  std::atomic<bool> wants_local_model_ = false;
  std::atomic<bool> stopped_ = true, ends_ = true;
  std::atomic<Problem> reason_ = Problem::kNone;
  Wake written_;
  std::thread sender_;
};

}  // namespace palpate

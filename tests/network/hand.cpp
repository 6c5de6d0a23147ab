// A hand that holds a device and presses it on a floor, at the other end of a link, by the reference client:
// what tools/network.sh measures. Prints one line of figures.
//
//     hand HOST PORT TOKEN wrench|local FLOOR [COMMAND]
//
// FLOOR is the height at which the tool touches, in metres. COMMAND is run while the hand presses, and cuts
// the link; how long the force lasts from its end on is the last figure.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <thread>
#include <vector>

#include <client/palpate_client.h>

namespace {

using palpate_client::Client;

constexpr double kTick = 1e-3;                 // s
constexpr double kDamping = 2.0;               // N s/m: 1 of the device, and 1 of the hand
constexpr double kResolution = 1e-5;           // m, of the device's encoders
constexpr double kAbove = 0.005;               // m, over the floor
constexpr double kPressed[] = {0.006, 0.012};  // m, where the hand wants to be, under the floor
constexpr double kSpeed = 0.05;                // m/s, of where it wants to be
constexpr double kWait = 1.5;                  // s, above the floor, until the gates are open
constexpr double kRest = 2.0;                  // s, at each depth, of which the last is measured
constexpr double kWindow = 1.0;                // s
constexpr double kPatience = 25.0;             // s, for a press without a drop

/// Device and hand: a mass on a spring of the hand's, with the damping of both.
class Hand {
 public:
  explicit Hand(double z) : z_(z), target_(z) {}

  /// For a tick, under a force that is held. \returns the work that the force has done. Unit: [J].
  double move(double target, double force) {
    constexpr double kMass = 0.2, kStiffness = 300.0;  // kg, N/m
    constexpr int kSteps = 40;
    constexpr double kStep = kTick / kSteps;
    target_ += std::clamp(target - target_, -kSpeed * kTick, kSpeed * kTick);
    const double before = z_;
    for (int k = 0; k < kSteps; ++k) {
      velocity_ += kStep * (kStiffness * (target_ - z_) - kDamping * velocity_ + force) / kMass;
      z_ += kStep * velocity_;
      absorbed_ += kStep * kDamping * velocity_ * velocity_;
    }
    return force * (z_ - before);
  }

  double z() const { return z_; }
  double measured() const { return kResolution * std::round(z_ / kResolution); }
  /// By the damping. Unit: [J].
  double absorbed() const { return absorbed_; }

 private:
  double z_, target_, velocity_ = 0.0, absorbed_ = 0.0;
};

/// At rest on the floor.
struct Rest {
  double z = 0.0, force = 0.0;      // mean; m, N
  double least = 1e9, most = -1e9;  // m
  double port_energy = 0.0;         // J, by the force
  int ticks = 0;
  void add(double at, double shown, double work) {
    ++ticks;
    z += (at - z) / ticks;
    force += (shown - force) / ticks;
    least = std::min(least, at);
    most = std::max(most, at);
    port_energy += work;
  }
};

class Trial {
 public:
  Trial(Client& client, double floor) : client_(client), floor_(floor), hand_(floor + kAbove) {}

  /// Presses until both rests are measured. \returns false if the force has never lasted for so long.
  bool press() {
    while (now() < kPatience) {
      rests_[0] = rests_[1] = {};
      if (stay(floor_ + kAbove, kWait, nullptr) && rest(0) && rest(1)) return true;
      ++drops_;
    }
    return false;
  }

  /// How long there is a force after `command`. Unit: [s].
  double cut(const char* command) {
    std::atomic<double> cut_at = 0.0;
    std::thread other([&] {
      if (std::system(command) != 0) std::fputs("hand: the link cannot be cut\n", stderr);
      cut_at = Client::now();
    });
    double last = 0.0;
    for (const double end = now() + 1.0; now() < end;) {
      tick(floor_ - kPressed[1]);
      if (force_ != 0.0) last = Client::now();
    }
    other.join();
    return last - cut_at;
  }

  void print(double lasts) {
    std::sort(ages_.begin(), ages_.end());
    const auto age = [&](double p) {
      return ages_.empty() ? std::nan("")
                           : 1e3 * ages_[static_cast<std::size_t>(p * static_cast<double>(ages_.size() - 1))];
    };
    const auto if_measured = [&](double figure) { return rests_[1].ticks > 0 ? figure : std::nan(""); };
    const double stiffness = if_measured((rests_[1].force - rests_[0].force) / (rests_[0].z - rests_[1].z));
    std::printf("%d %.0f %.3f %.2f %.1f %.1f %.0f %.0f\n", drops_,
                if_measured(1e6 * (rests_[1].most - rests_[1].least)),
                if_measured(1e3 * rests_[1].port_energy), 1e3 * (put_out_ - hand_.absorbed()), age(0.5),
                age(0.99), stiffness, 1e3 * lasts);
  }

 private:
  double now() const { return kTick * ticks_; }

  void tick(double target) {
    const double measured = hand_.measured();
    force_ = client_.wrench({0.0, 0.0, measured}).force[2];
    client_.send({{0.0, 0.0, measured}, {1.0, 0.0, 0.0, 0.0}}, Client::now());
    work_ = hand_.move(target, force_);
    put_out_ += work_;
    ++ticks_;
    std::this_thread::sleep_until(begin_ + std::chrono::milliseconds(ticks_));
  }

  /// Goes to `target`. \returns false if there is no force on the floor for 50 ms.
  bool stay(double target, double seconds, Rest* rest) {
    constexpr int kDropped = 50;  // ticks
    int without = 0;
    for (const double end = now() + seconds; now() < end;) {
      tick(target);
      without = force_ == 0.0 && hand_.z() < floor_ - 1e-3 ? without + 1 : 0;
      if (without > kDropped) return false;
      if (rest == nullptr) continue;
      ages_.push_back(Client::now() - client_.answered());
      if (now() > end - kWindow) rest->add(hand_.z(), force_, work_);
    }
    return true;
  }
  bool rest(int k) { return stay(floor_ - kPressed[k], kRest, &rests_[k]); }

  Client& client_;
  double floor_;
  Hand hand_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  int ticks_ = 0, drops_ = 0;
  double force_ = 0.0, work_ = 0.0, put_out_ = 0.0;
  Rest rests_[2];
  std::vector<double> ages_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 6 && argc != 7) {
    std::fputs("usage: hand HOST PORT TOKEN wrench|local FLOOR [COMMAND]\n", stderr);
    return 2;
  }
  try {
    const bool local = std::string(argv[4]) == "local";
    Client client({.force_max = 12.0, .torque_max = 0.0, .damping = local ? kDamping : 0.0});
    client.connect(argv[1], static_cast<std::uint16_t>(std::atoi(argv[2])), argv[3]);
    Trial trial(client, std::atof(argv[5]));
    const bool pressed = trial.press();
    trial.print(argc == 7 && pressed ? trial.cut(argv[6]) : std::nan(""));
    return pressed ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hand: %s\n", error.what());
    return 1;
  }
}

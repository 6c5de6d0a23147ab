// A client that is the device: a simulated hand lowers a handle onto the scene and lifts it again, every four
// seconds, and the height of the handle and the force are printed.
//
//     g++ -std=c++20 -O2 -pthread main.cpp -o palpate_client
//     palpate make-scene sphere --out sphere.ply
//     palpate run sphere.ply --device client --client-rate 1000 --tool 0.02,0.02,0.02
//     ./palpate_client 127.0.0.1 9090
//
// With --local it renders the program's local model itself, for a link that is slow: docs/network.md.
//
// With a real device: read the pose from its driver in place of Hand::move(), and hand the wrench to its
// motors in Motors::show().
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "palpate_client.h"

namespace {

using palpate_client::Client;

constexpr double kTick = 1e-3;  // s

/// A handle that a hand holds by a spring and a damper, and moves up and down. Along z; the rest is at zero.
class Hand {
 public:
  static constexpr double kBegin = 0.21;   // m
  static constexpr double kDamping = 5.0;  // N s/m

  /// \param force on the handle. Unit: [N]. \returns where it is. Unit: [m].
  double move(double t, double force) {
    constexpr double kMass = 0.15, kStiffness = 300.0;  // kg, N/m
    constexpr double kMiddle = 0.18, kSwing = 0.03,
                     kPeriod = 4.0;  // m, m, s: the sphere is felt below 0.17 m
    const double target = kMiddle + kSwing * std::cos(2.0 * M_PI * t / kPeriod);
    velocity_ += kTick * (kStiffness * (target - z_) - kDamping * velocity_ + force) / kMass;
    z_ += kTick * velocity_;
    return z_;
  }

 private:
  double z_ = kBegin, velocity_ = 0.0;
};

/// Prints height and force ten times a second, on a thread of its own: a terminal that takes no text would
/// hold up the motors otherwise. In the end, what the motors were told last.
class Display {
 public:
  ~Display() {
    ends_ = true;
    thread_.join();
    std::printf("the motors show %.2f N\n", force_.load());
  }
  void tell_height(double z) noexcept { z_ = z; }
  void tell_force(double force) noexcept { force_ = force; }

 private:
  void print() {
    while (!ends_) {
      std::printf("z %6.1f mm   force %5.2f N\n", 1e3 * z_, force_.load());
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }

  std::atomic<double> z_ = Hand::kBegin, force_ = 0.0;
  std::atomic<bool> ends_ = false;
  std::thread thread_{[this] { print(); }};
};

/// Motors keep the last force that they were told. Whatever ends the loop, an exception of the driver too,
/// the last is zero.
class Motors {
 public:
  explicit Motors(Display& display) : display_(display) {}
  ~Motors() { show(0.0); }
  void show(double force) noexcept {
    force_ = force;
    display_.tell_force(force);
  }
  double force() const noexcept { return force_; }

 private:
  Display& display_;
  double force_ = 0.0;
};

volatile std::sig_atomic_t ends = 0;

void feel(Client& client) {
  Hand hand;
  Display display;
  Motors motors(display);
  double z = Hand::kBegin;
  const auto begin = std::chrono::steady_clock::now();
  // From the end on no pose is sent: the force falls to zero, in 5 ms where the connection is lost, and 100
  // ms after the last pose at the latest. Leaving at once would leave the motors at the force of the last
  // tick.
  bool falls = false;
  for (int tick = 0; !falls || motors.force() != 0.0; ++tick) {
    falls = falls || ends != 0 || !client.is_connected();
    motors.show(client.wrench({0.0, 0.0, z}).force[2]);
    z = hand.move(kTick * tick, motors.force());
    if (!falls) client.send({{0.0, 0.0, z}, {1.0, 0.0, 0.0, 0.0}}, Client::now());
    display.tell_height(z);
    std::this_thread::sleep_until(begin + std::chrono::milliseconds(tick + 1));
  }
}

}  // namespace

int main(int argc, char** argv) {
  const bool local = argc > 1 && std::string_view(argv[1]) == "--local";
  const std::vector<std::string> arguments(argv + (local ? 2 : 1), argv + argc);
  if (arguments.size() != 2 && arguments.size() != 3) {
    std::fputs("usage: palpate_client [--local] HOST PORT [TOKEN]\n", stderr);
    return 2;
  }
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(signal, [](int) { ends = 1; });
  try {
    std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
    Client client({.force_max = 12.0, .torque_max = 0.0, .damping = local ? Hand::kDamping : 0.0});
    client.on_status = [](const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); };
    client.connect(arguments[0], static_cast<std::uint16_t>(std::atoi(arguments[1].c_str())),
                   arguments.size() == 3 ? arguments[2] : "");
    feel(client);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "palpate_client: %s\n", error.what());
    return 1;
  }
  if (ends != 0) return 0;
  std::fputs("palpate_client: the connection has ended\n", stderr);
  return 1;
}

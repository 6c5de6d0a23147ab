// A client that is the device: a simulated hand lowers a handle onto the scene and lifts it again, every four
// seconds, and the height of the handle and the force are printed.
//
//     g++ -std=c++20 -O2 -pthread main.cpp -o palpate_client
//     palpate make-scene sphere --out sphere.ply
//     palpate run sphere.ply --device client --client-rate 1000 --tool 0.02,0.02,0.02
//     ./palpate_client 127.0.0.1 9090
//
// With a real device: read the pose from its driver in place of Hand::move(), and hand the wrench to its
// motors.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "palpate_client.h"

namespace {

using palpate_client::Client;

constexpr double kTick = 1e-3;  // s

/// A handle that a hand holds by a spring and a damper, and moves up and down. Along z; the rest is at zero.
class Hand {
 public:
  /// \param force on the handle. Unit: [N]. \returns where it is. Unit: [m].
  double move(double t, double force) {
    constexpr double kMass = 0.15, kDamping = 5.0, kStiffness = 300.0;  // kg, N s/m, N/m
    constexpr double kMiddle = 0.18, kSwing = 0.03,
                     kPeriod = 4.0;  // m, m, s: the sphere is felt below 0.17 m
    const double target = kMiddle + kSwing * std::cos(2.0 * M_PI * t / kPeriod);
    velocity_ += kTick * (kStiffness * (target - z_) - kDamping * velocity_ + force) / kMass;
    z_ += kTick * velocity_;
    return z_;
  }

 private:
  double z_ = 0.21, velocity_ = 0.0;
};

void feel(Client& client) {
  Hand hand;
  const auto begin = std::chrono::steady_clock::now();
  for (int tick = 0; client.is_connected(); ++tick) {
    const double force = client.wrench().force[2];
    const double z = hand.move(kTick * tick, force);
    client.send({{0.0, 0.0, z}, {1.0, 0.0, 0.0, 0.0}}, Client::now());
    if (tick % 100 == 0) std::printf("z %6.1f mm   force %5.2f N\n", 1e3 * z, force);
    std::this_thread::sleep_until(begin + std::chrono::milliseconds(tick + 1));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) {
    std::fputs("usage: palpate_client HOST PORT [TOKEN]\n", stderr);
    return 2;
  }
  try {
    std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
    Client client({.force_max = 12.0, .torque_max = 0.0});
    client.on_status = [](const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); };
    client.connect(argv[1], static_cast<std::uint16_t>(std::atoi(argv[2])), argc == 4 ? argv[3] : "");
    feel(client);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "palpate_client: %s\n", error.what());
    return 1;
  }
  std::fputs("palpate_client: the connection has ended\n", stderr);
  return 1;
}

// Feels a scene with a device of one's own. Usage: embed [SCENE.ply X Y Z], a point on its surface, in m
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <thread>

#include <palpate/base/error.h>
#include <palpate/live/live_system.h>
#include <palpate/servo/live_view.h>

/// A driver: here its handle goes up and down by itself, and its motors are not there.
class Probe final : public palpate::HapticDevice {
 public:
  explicit Probe(const Eigen::Vector3d& place) : place_(place) {
    capabilities_.name = "probe";
    capabilities_.force_max = 10.0;
  }
  const palpate::DeviceCapabilities& capabilities() const override { return capabilities_; }
  bool read(double t, palpate::DeviceReading& reading) override {
    reading.t = t;
    reading.pose.position = place_ + Eigen::Vector3d(0, 0, 0.06 + 0.03 * std::cos(3.0 * t));
    return true;
  }
  void write(const palpate::Wrench&) override {}  // to the motors

 private:
  palpate::DeviceCapabilities capabilities_;
  Eigen::Vector3d place_;
};

int main(int argc, char** argv) {
  palpate::LiveConfig config;  // without a path: the built-in scene, a still life on a table
  config.force.proxy.stiffness = 800.0;
  Eigen::Vector3d place(0.2, -0.22, 0.0);  // free table
  if (argc == 5) {
    config.scene.path = argv[1];
    place = {std::atof(argv[2]), std::atof(argv[3]), std::atof(argv[4])};
  }
  try {
    palpate::LiveSystem system(config, std::make_unique<Probe>(place));
    palpate::LiveView view;
    system.start({&view});
    std::this_thread::sleep_for(std::chrono::seconds(4));
    system.stop();
    view.update();
    std::cout << system.loop().statistics().ticks << " ticks, up to " << view.totals().contacts_max
              << " contacts and " << view.totals().force_max << " N\n";
  } catch (const palpate::Error& error) {
    std::cerr << "embed: " << error.what() << "\n";
    return 1;
  }
}

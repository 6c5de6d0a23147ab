// A hand that walks around a scene with the room-scale device and moves there as hands have been recorded to:
// no fault, and every joint within its limits at every tick. Needs PALPATE_TRAJECTORIES, a folder of tables
// px,py,pz,... at 1 kHz, for recorded motion, and PALPATE_SCENES, a folder with seal.ply, for a captured
// scene; without them both are made.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>

#include <gtest/gtest.h>

#include <palpate/device/giant_plant.h>
#include <palpate/device/giant_setup.h>
#include <palpate/device/hand_path.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/kinematics/chain_file.h>
#include <palpate/scene/load_scene.h>
#include <palpate/servo/servo_tick.h>
#include <palpate/study/procedural.h>
#include <palpate/study/room_path.h>
#include <support/effort.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::is_long;

constexpr double kControlTick = 1e-3;  // [s]
constexpr double kWide = 1.2;          // of the scene in the room. [m]

/// The ways of the hand from where each recording begins, there and back.
Trajectory recorded_motion() {
  std::vector<std::vector<Vector3d>> recordings;
  if (const char* folder = std::getenv("PALPATE_TRAJECTORIES")) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() == ".csv") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const auto& file : files) {
      std::ifstream table(file);
      std::string line;
      std::getline(table, line);
      EXPECT_EQ(line.rfind("px,py,pz,", 0), 0U) << file;
      auto& way = recordings.emplace_back();
      while (std::getline(table, line)) {
        Vector3d p;
        if (std::sscanf(line.c_str(), "%lf,%lf,%lf", &p.x(), &p.y(), &p.z()) == 3) way.push_back(p);
      }
    }
  } else {
    auto& way = recordings.emplace_back();
    for (double t = 0.0; t < 5.0; t += kControlTick) {
      const double swell = std::pow(std::sin(std::numbers::pi * t / 5.0), 2);
      way.push_back(swell *
                    Vector3d(0.09 * std::sin(5.0 * t), 0.07 * std::sin(7.3 * t), 0.03 * std::sin(11.0 * t)));
    }
  }
  Trajectory motion;
  const auto append = [&](const Vector3d& p) {
    motion.push_back(
        {kControlTick * static_cast<double>(motion.size()), {p, Eigen::Quaterniond::Identity()}, {}});
  };
  for (const auto& way : recordings) {
    for (const Vector3d& p : way) append(p - way.front());
    for (auto p = way.rbegin(); p != way.rend(); ++p) append(*p - way.front());
  }
  return motion;
}

GaussianScene made_scene() {
  ProceduralOptions options;
  options.spacing = 0.03;
  options.noise = 0.003;
  return make_scene(*make_surface("truck"), options);
}

/// A scene beside where the handle rests, as high as it reaches.
struct PlacedScene {
  explicit PlacedScene(const GaussianScene& scene) {
    FilterReport report;
    const Eigen::AlignedBox3d box = central_box(filter_scene(scene, {}, placed, report));
    placed.scale = kWide / box.sizes().head<2>().maxCoeff();
    const Vector3d top(box.center().x(), box.center().y(), box.max().z());
    placed.translation =
        Vector3d(0.0, -0.35 - 0.5 * placed.scale * box.sizes().y(), giant_reach().max().z() - 0.18) -
        placed.scale * top;
    index = std::make_unique<SceneIndex>(scene, SceneFilter{}, placed);
    kept = filter_scene(scene, {}, placed, report);
  }
  Similarity placed;
  std::unique_ptr<SceneIndex> index;
  EllipsoidScene kept;
};

/// The joints from tick to tick, against their limits.
class JointWatch {
 public:
  explicit JointWatch(const JointMotion& joints) : joints_(joints), q_(joints.position()) {
    dq_.setZero(q_.size());
  }
  void look() {
    const ChainLimits& limits = joints_.limits();
    const JointVector q = joints_.position(), dq = (q - q_) / kControlTick, ddq = (dq - dq_) / kControlTick;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const double beyond = std::max(limits.lower[i] - q[i], q[i] - limits.upper[i]);
      position_ = std::max(position_, beyond);
      velocity_ = std::max(velocity_, std::abs(dq[i]) / limits.velocity[i]);
      acceleration_ = std::max(acceleration_, std::abs(ddq[i]) / limits.acceleration[i]);
    }
    q_ = q;
    dq_ = dq;
  }
  void expect_kept() const {
    EXPECT_LE(position_, 0.0);
    EXPECT_LE(velocity_, 1.0 + 1e-9);
    EXPECT_LE(acceleration_, 1.0 + 1e-6);
    std::printf("joints: nearest to an end %.3f, fastest %.2f and hardest %.2f of the limit\n", -position_,
                velocity_, acceleration_);
  }

 private:
  const JointMotion& joints_;
  JointVector q_, dq_;
  double position_ = -1e9, velocity_ = 0.0, acceleration_ = 0.0;
};

void walk_through(const GaussianScene& scene, double seconds) {
  const PlacedScene room(scene);
  GiantSetup setup;
  setup.hand = {0.15, 4.0, 400.0};
  setup.chain = driven_chain(giant_chain(), setup.hand);
  setup.contact_stiffness = ProxyParameters().stiffness;
  const Tool tool{Vector3d::Constant(0.03)};
  RoomPathOptions way;
  way.home = rest_of_handle(setup.chain);
  way.reach = giant_reach();
  way.touches = 5;
  const HandPath hand = [walk = to_and_fro(room_path(*room.index, room.kept, tool, way).path),
                         moves = to_and_fro(recorded_motion())](double t) {
    Pose pose = walk(t);
    const Eigen::AngleAxisd turned(0.1 * t, Vector3d::UnitZ());  // each round in other directions
    pose.position += turned * moves(t).position;
    return pose;
  };
  GiantDevice device(setup.chain,
                     std::make_unique<GiantPlant>(setup.chain, GiantProperties().drives,
                                                  GripProperties{setup.hand, 0.05}, hand),
                     GiantProperties(), way.home);
  AdmittanceLoopOptions options;
  options.along = loop_of(setup);
  options.about = loop_model(setup.chain, GiantProperties());
  options.admittance = admittance_of(setup);
  AdmittanceLoop loop(device, options);
  ProxyForce force(*room.index, tool, ProxyParameters());
  ServoTick tick(loop, {&force, nullptr});
  JointWatch joints(device.joints());
  std::size_t touched = 0, held = 0, ticks = 0;
  double most = 0.0, farthest = 0.0;
  for (; kControlTick * static_cast<double>(ticks) < seconds; ++ticks) {
    const TickRecord& now = tick.run(kControlTick * static_cast<double>(ticks));
    ASSERT_EQ(now.fault, Fault::kNone) << traits(now.fault).name << " at " << now.t << " s";
    ASSERT_NE(loop.status(), DeviceStatus::kFault) << loop.status_text() << " at " << now.t << " s";
    joints.look();
    touched += static_cast<std::size_t>(now.sent.force.norm() > 0.1);
    held += static_cast<std::size_t>(*loop.held_by() != '\0');
    most = std::max(most, now.sent.force.norm());
    farthest = std::max(farthest, (device.pose().position - way.home.position).norm());
  }
  std::printf(
      "%.0f s: touched %.0f %% of the time, %.1f N at most, %.2f m from home, held by a limit %.2f %%\n",
      seconds, 100.0 * static_cast<double>(touched) / static_cast<double>(ticks), most, farthest,
      100.0 * static_cast<double>(held) / static_cast<double>(ticks));
  joints.expect_kept();
  EXPECT_GT(touched, ticks / 20);
}

TEST(RecordedMotion, KeepsEveryJointWithinItsLimitsAroundATruck) {
  walk_through(made_scene(), is_long() ? 600.0 : 20.0);
}

TEST(RecordedMotion, KeepsEveryJointWithinItsLimitsAroundACapture) {
  const char* folder = std::getenv("PALPATE_SCENES");
  if (folder == nullptr || *folder == '\0') GTEST_SKIP() << "set PALPATE_SCENES to the folder of seal.ply";
  walk_through(load_scene(std::string(folder) + "/seal.ply"), is_long() ? 600.0 : 20.0);
}

}  // namespace
}  // namespace palpate

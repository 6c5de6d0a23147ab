// The worker that looks for contacts is 50 ms late: what comes of it in the hand.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/device/profiles.h>
#include <palpate/haptics/field_force.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/haptics/zero_order_hold.h>
#include <palpate/servo/servo_tick.h>
#include <palpate/study/procedural.h>
#include <support/noisy_plane.h>
#include <support/tick.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::kTick;

constexpr double kToolRadius = 0.02, kLate = 0.05;

enum class Contacts { kInline, kLookahead, kHold };

/// An omega in a hand that presses 5 mm into a plane, rests for two seconds, and slides at 0.1 m/s.
class Session {
 public:
  Session(const std::string& model, Contacts contacts, bool watched = false) {
    Lookahead* const ahead = contacts == Contacts::kLookahead ? &lookahead_ : nullptr;
    if (model == "field") {
      model_ = std::make_unique<FieldForce>(tool_);
    } else {
      model_ = std::make_unique<ProxyForce>(test::noisy_plane(), tool_, ProxyParameters{}, ahead);
    }
    tracker_ = std::make_unique<ToolTracker>(test::noisy_plane(), tool_, Precision::kDouble, ahead);
    seen_ = std::make_unique<ToolTracker>(test::noisy_plane(), tool_);
    FeltModel felt{model_.get(), tracker_.get()};
    std::vector<BackgroundWork*> work{&lookahead_};
    if (contacts == Contacts::kHold) {
      held_ = std::make_unique<ZeroOrderHold>(*model_, model_->wants_contacts() ? tracker_.get() : nullptr);
      felt = {held_.get(), seen_.get()};
      work.push_back(held_.get());
    }
    worker_ = std::make_unique<VirtualWorker>(work, contacts == Contacts::kInline ? 0.0 : kLate);
    felt.worker = worker_.get();
    const DeviceProfile& omega = device_profile("omega");
    device_ =
        std::make_unique<SimulatedDevice>(omega.capabilities, omega.plant, HandProperties{}, [](double t) {
          const double down = std::clamp((t - 0.8) / 0.5, 0.0, 1.0);
          Pose pose;
          pose.position.z() = kToolRadius + 0.01 - 0.015 * down * down * (3.0 - 2.0 * down);
          pose.position.x() = 0.1 * std::max(0.0, t - 3.5);
          return pose;
        });
    ServoTickOptions options;
    if (contacts == Contacts::kHold && !watched) {  // else the governor ends it
      options.limits = SafetyLimits::of(omega.capabilities, kTick);
      options.limits->energy_max = std::numeric_limits<double>::infinity();
    }
    loop_ = std::make_unique<ServoTick>(*device_, felt, options);
  }

  const TickRecord& tick() {
    const double t = kTick * static_cast<double>(count_++);
    worker_->run_until(t);
    return loop_->run(t);
  }
  const TickRecord& tick_until(double t) {
    while (kTick * (count_ + 1) < t) tick();
    return tick();
  }
  const Vector3d& position() const { return device_->pose().position; }
  double time() const { return kTick * count_; }

 private:
  Tool tool_{Vector3d::Constant(kToolRadius)};
  Lookahead lookahead_;
  std::unique_ptr<ForceModel> model_;
  std::unique_ptr<ToolTracker> tracker_, seen_;
  std::unique_ptr<ZeroOrderHold> held_;
  std::unique_ptr<VirtualWorker> worker_;
  std::unique_ptr<SimulatedDevice> device_;
  std::unique_ptr<ServoTick> loop_;
  int count_ = 0;
};

/// Peak to peak of the handle while the hand rests. Unit: [m].
double limit_cycle(Session& session) {
  session.tick_until(2.5);
  Eigen::AlignedBox3d rest;
  while (session.time() < 3.5) {
    session.tick();
    rest.extend(session.position());
  }
  return rest.diagonal().norm();
}

class LateWorker : public testing::TestWithParam<const char*> {};

TEST_P(LateWorker, TheHandRests) {
  Session session(GetParam(), Contacts::kLookahead);
  EXPECT_LE(limit_cycle(session), 0.05e-3);
  EXPECT_EQ(session.tick().state, GovernorState::kActive);
  EXPECT_GT(session.tick().sent_world.force.z(), 0.5);
}

// Which Gaussians are touched does not depend on who looked for them; their figures do by rounding, and with
// that when an encoder counts.
TEST_P(LateWorker, SlidingFeelsTheSameAsWithoutDelay) {
  const double two_counts = 2.0 * device_profile("omega").plant.resolution * ProxyParameters{}.stiffness;
  Session late(GetParam(), Contacts::kLookahead), prompt(GetParam(), Contacts::kInline);
  late.tick_until(3.6);
  prompt.tick_until(3.6);
  while (late.time() < 5.0) {
    const Vector3d felt = prompt.tick().sent_world.force;
    EXPECT_LE((late.tick().sent_world.force - felt).norm(), two_counts);
    EXPECT_GT(felt.norm(), 0.5);
  }
}

TEST_P(LateWorker, AForceThatIsHeldShakesTheHand) {
  Session session(GetParam(), Contacts::kHold);
  EXPECT_GT(limit_cycle(session), 1e-3);
}

TEST_P(LateWorker, TheGovernorEndsThat) {
  Session session(GetParam(), Contacts::kHold, true);
  session.tick_until(2.5);
  EXPECT_EQ(session.tick().fault, Fault::kOverEnergy);
  EXPECT_EQ(session.tick().sent_world.force, Vector3d(Vector3d::Zero()));
}

INSTANTIATE_TEST_SUITE_P(Models, LateWorker, testing::Values("field", "proxy"));

}  // namespace
}  // namespace palpate

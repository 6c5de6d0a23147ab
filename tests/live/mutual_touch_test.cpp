// What two hands feel of each other, without threads: their models are asked in turn.
#include <palpate/live/mutual_touch.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/device/profiles.h>
#include <palpate/device/simulated_device.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/servo/servo_tick.h>

#include <support/allocation_guard.h>
#include <support/noisy_plane.h>

namespace palpate::test {
namespace {

using Eigen::Vector3d;

constexpr double kStiffness = 600.0;  // N/m of each hand: half of it between two
constexpr double kTick = 1e-3;

/// There is nothing to feel but hands.
class Nothing final : public ForceModel {
 public:
  bool wants_contacts() const override { return false; }
  void reset() override {}
  ForceOutput evaluate(const ForceInput& input) override { return {Wrench{}, input.tool}; }
};

/// Hands that are where they are told.
class Hands {
 public:
  explicit Hands(const std::vector<Tool>& tools) : touch_(tools.size()) {
    for (std::size_t k = 0; k < tools.size(); ++k)
      models_.push_back(touch_.around(k, nothing_, tools[k], kStiffness));
  }
  ForceOutput feel(std::size_t hand, const Pose& pose, double force_scale = 1.0) {
    ForceInput input;
    input.tool = pose;
    input.force_scale = force_scale;
    return models_[hand]->evaluate(input);
  }
  ForceOutput feel(std::size_t hand, double x, double force_scale = 1.0) {
    return feel(hand, Pose{Vector3d(x, 0, 0), Eigen::Quaterniond::Identity()}, force_scale);
  }
  void reset(std::size_t hand) { models_[hand]->reset(); }
  ForceModel& model(std::size_t hand) { return *models_[hand]; }

 private:
  Nothing nothing_;
  MutualTouch touch_;
  std::vector<std::unique_ptr<ForceModel>> models_;
};

Tool ball(double radius = 0.01) { return Tool(Vector3d::Constant(radius)); }

TEST(MutualTouch, WhoWaitsAtTheGateIsNotThere) {
  Hands hands({ball(), ball()});
  hands.feel(0, 0.0);
  EXPECT_TRUE(hands.feel(1, 0.019, 0.0).wrench.force.isZero(0.0));
  EXPECT_TRUE(hands.feel(0, 0.0).wrench.force.isZero(0.0));
  hands.feel(1, 0.019, 0.3);  // its force begins to rise, in the other tool
  EXPECT_TRUE(hands.feel(0, 0.0).wrench.force.isZero(0.0));
  EXPECT_TRUE(hands.feel(1, 0.019, 0.3).wrench.force.isZero(0.0)) << "not before they have been apart";
}

TEST(MutualTouch, AForceThatRisesIsEqualAndOppositeWithTheFractionOfEither) {
  Hands hands({ball(), ball()});
  constexpr double kRises = 0.3, kAll = 0.8;
  for (int k = 0; k < 2; ++k) {
    hands.feel(0, 0.0, kAll);
    hands.feel(1, 0.03, kRises);
  }
  hands.feel(1, 0.019, kRises);
  const double on_first =
      hands.feel(0, 0.0, kAll).wrench.force.x() * kAll;  // as the governors let it through
  const double on_other = hands.feel(1, 0.019, kRises).wrench.force.x() * kRises;
  EXPECT_NEAR(on_other, 0.5 * kStiffness * 0.001 * kRises * kAll, 1e-9);
  EXPECT_NEAR(on_first, -on_other, 1e-9);
}

TEST(MutualTouch, BallsRepelByTheirOverlap) {
  Hands hands({ball(), ball()});
  for (const double x : {0.03, 0.02001}) {
    hands.feel(0, 0.0);
    EXPECT_TRUE(hands.feel(1, x).wrench.force.isZero(0.0)) << x;
    EXPECT_EQ(hands.feel(1, x).stiffness, 0.0);
  }
  const ForceOutput felt = hands.feel(1, 0.019);
  EXPECT_NEAR(felt.wrench.force.x(), 0.5 * kStiffness * 0.001, 1e-9);
  EXPECT_NEAR(felt.wrench.force.tail<2>().norm(), 0.0, 1e-9);
  EXPECT_NEAR(felt.stored_energy, 0.25 * kStiffness * 1e-6, 1e-12);
  EXPECT_EQ(felt.stiffness, 0.5 * kStiffness);
}

// Held 50 mm beside its centre, a ball of 10 mm is pushed at that lever. What the hand feels is as stiff as
// at the longest that the tool has, whichever contact comes next.
TEST(MutualTouch, TellsTheStiffnessAboutTheHandle) {
  Pose beside;
  beside.position.y() = 0.05;
  Hands hands({ball(), Tool({{"beside", ball().parts()[0].semi_axes, beside}})});
  Pose apart, there;
  apart.position = {0.1, -0.05, 0.0};
  there.position = {0.019, -0.05, 0.0};
  hands.feel(0, Pose{});
  EXPECT_FALSE(hands.feel(1, apart).at_lever);
  const ForceOutput felt = hands.feel(1, there);
  EXPECT_NEAR(felt.wrench.torque.z(), -0.05 * felt.wrench.force.x(), 1e-9);
  EXPECT_NEAR(felt.angular_stiffness, 0.06 * 0.06 * 0.5 * kStiffness, 1e-9);
  EXPECT_TRUE(felt.at_lever);
}

TEST(MutualTouch, IsEqualAndOppositeAndSmoothFromTheFirstTouch) {
  Pose beside;
  beside.position.x() = 0.01;
  const Tool plate({{"plate", Vector3d(0.03, 0.02, 0.002), beside}, {"rod", Vector3d(0.004, 0.004, 0.03)}});
  Hands hands({plate, Tool(Vector3d(0.01, 0.015, 0.03))});
  Pose fixed, moving;
  fixed.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3d(1, 2, 0.5).normalized()));
  moving.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(-0.7, Vector3d(0.2, 1, 1).normalized()));
  constexpr double kStep = 1e-5;
  double before = 0.0, largest = 0.0;
  for (double z = 0.08; z > 0.02; z -= kStep) {
    moving.position = {0.004, -0.003, z};
    hands.feel(0, fixed);
    const Wrench b = hands.feel(1, moving).wrench;
    const Wrench a = hands.feel(0, fixed).wrench;
    ASSERT_EQ(a.force, -b.force) << z;
    // About one point.
    ASSERT_LT((a.torque + b.torque + moving.position.cross(b.force)).norm(), 1e-12 + 1e-12 * a.force.norm())
        << z;
    // Each pair of parts adds its own spring; the normal turns a little, too.
    ASSERT_LT(std::abs(a.force.norm() - before), 4.0 * kStiffness * kStep) << z;
    before = a.force.norm();
    largest = std::max(largest, before);
  }
  EXPECT_GT(largest, 1.0);
}

TEST(MutualTouch, WhoIsNotThereIsNotFelt) {
  Hands hands({ball(), ball()});
  for (const double x : {0.03, 0.018}) {
    hands.feel(0, 0.0);
    hands.feel(1, x);
  }
  EXPECT_GT(hands.feel(1, 0.018).wrench.force.x(), 0.0);
  hands.reset(0);
  EXPECT_TRUE(hands.feel(1, 0.018).wrench.force.isZero(0.0));
  EXPECT_EQ(hands.feel(1, 0.018).stored_energy, 0.0);
}

TEST(MutualTouch, WhoComesBackIntoAnotherPushesOnlyOnceTheyWereApart) {
  Hands hands({ball(), ball()});
  const auto both = [&](double x) {
    hands.feel(0, 0.0);
    const Vector3d b = hands.feel(1, x).wrench.force, a = hands.feel(0, 0.0).wrench.force;
    EXPECT_EQ(a, -b) << x;
    return b.x();
  };
  EXPECT_EQ(both(0.018), 0.0) << "from the beginning";
  EXPECT_EQ(both(0.021), 0.0);
  EXPECT_GT(both(0.018), 0.0);
  for (const std::size_t hand : {0U, 1U}) {
    hands.reset(hand);
    EXPECT_EQ(both(0.018), 0.0) << "hand " << hand << " came back";
    EXPECT_EQ(both(0.015), 0.0);
    EXPECT_EQ(both(0.021), 0.0);
    EXPECT_GT(both(0.018), 0.0);
  }
}

TEST(MutualTouch, OfThreeEachFeelsTheOthers) {
  Hands hands({ball(), ball(), ball()});
  const auto step = [&](double x) {
    std::vector<Vector3d> forces;
    for (int turn = 0; turn < 2; ++turn)
      forces = {hands.feel(0, 0.0).wrench.force, hands.feel(1, x).wrench.force,
                hands.feel(2, -x).wrench.force};
    return forces;
  };
  step(0.03);
  const auto forces = step(0.019);
  EXPECT_NEAR(forces[0].norm(), 0.0, 1e-12);
  EXPECT_NEAR(forces[1].x(), 0.5 * kStiffness * 0.001, 1e-9);
  EXPECT_NEAR(forces[2].x(), -0.5 * kStiffness * 0.001, 1e-9);
}

TEST(MutualTouch, TakesNothingFromTheHeap) {
  Hands hands({ball(), ball()});
  const AllocationGuard guard;
  for (double x = 0.03; x > 0.015; x -= 1e-4) {
    hands.feel(0, 0.0);
    hands.feel(1, x);
  }
  hands.reset(0);
  hands.feel(0, 0.0);
  EXPECT_EQ(guard.count(), 0U);
}

/// A row of `count` balls of 10 mm along y, one every `apart`, in which two handles at one place coincide.
Tool row(std::size_t count, double apart) {
  std::vector<ToolPart> parts;
  for (std::size_t k = 0; k < count; ++k) {
    Pose pose;
    pose.position.y() = apart * (static_cast<double>(k) - 0.5 * static_cast<double>(count));
    parts.push_back({"ball", Vector3d::Constant(0.01), pose});
  }
  return Tool(parts);
}

// Side by side, 19 mm apart: each of 256 balls overlaps that beside it by 1 mm, and none overlaps another.
TEST(MutualTouch, ToolsOfAsManyPartsAsAToolMayHaveAreFeltWhole) {
  constexpr std::size_t kParts = 256;
  Hands hands({row(kParts, 0.01), row(kParts, 0.01)});
  for (const double x : {0.03, 0.019}) {
    hands.feel(0, 0.0);
    hands.feel(1, x);
  }
  const ForceOutput other = hands.feel(0, 0.0), felt = hands.feel(1, 0.019);
  EXPECT_NEAR(felt.wrench.force.x(), kParts * 0.5 * kStiffness * 0.001, 1e-6);
  EXPECT_EQ(felt.wrench.force, -other.wrench.force);
  EXPECT_EQ(felt.stiffness, kParts * 0.5 * kStiffness);
}

// All of 256 balls in one place overlap all of the others: those that are examined are felt, alike by both.
TEST(MutualTouch, ExaminesNoMorePairsThanItMay) {
  Hands hands({row(256, 0.0), row(256, 1e-6)});
  for (const double x : {0.03, 0.019}) {
    hands.feel(0, 0.0);
    hands.feel(1, x);
  }
  const AllocationGuard guard;
  const ForceOutput other = hands.feel(0, 0.0), felt = hands.feel(1, 0.019);
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(felt.stiffness, MutualTouch::kMostPairs * 0.5 * kStiffness);
  EXPECT_NEAR(felt.wrench.force.x(), MutualTouch::kMostPairs * 0.5 * kStiffness * 0.001, 1e-3);
  EXPECT_EQ(felt.wrench.force, -other.wrench.force);
}

// Long parts whose spheres overlap, but which do not touch, are not known to be apart where there are more of
// them than are examined: they push once they are.
TEST(MutualTouch, DoesNotBeginToPushWhereThereIsMoreThanItExamines) {
  const auto rods = [] { return Tool(std::vector<ToolPart>(17, {"rod", Vector3d(0.01, 0.01, 0.1)})); };
  Hands hands({rods(), rods()});
  const auto both = [&](double x) {
    hands.feel(0, 0.0);
    return hands.feel(1, x).wrench.force.x();
  };
  both(0.03);
  EXPECT_EQ(both(0.019), 0.0);
  both(0.21);
  EXPECT_GT(both(0.019), 0.0);
}

/// Two simulated devices in hands that are led into each other and back again, with all that a loop does.
class Pressed {
 public:
  Pressed() : hands_({ball(), ball()}), tracker_(noisy_plane(), ball()) {
    for (const std::size_t k : {0U, 1U}) {
      const DeviceProfile& profile = device_profile("omega");
      devices_.push_back(
          std::make_unique<SimulatedDevice>(profile.capabilities, profile.plant, HandProperties{}, path(k)));
      devices_.back()->enable();
      loops_.push_back(std::make_unique<ServoTick>(*devices_.back(), FeltModel{&hands_.model(k), &tracker_}));
    }
  }

  void run(double seconds) {
    for (int tick = 0; kTick * tick < seconds; ++tick) {
      for (const std::size_t k : {0U, 1U}) {
        const Wrench sent = records_[k].sent;
        const Vector3d was = records_[k].reading.pose.position;
        records_[k] = loops_[k]->run(kTick * tick);
        const Vector3d way = records_[k].reading.pose.position - was;
        const double absorbed = devices_[k]->capabilities().damping * way.squaredNorm() / kTick;
        if (tick > 0) net_ += sent.force.dot(way) - absorbed;
        largest_ = std::max(largest_, records_[k].sent.force.norm());
      }
      most_ = std::max(most_, net_);
    }
  }

  /// Put out by both, less what was taken in and what the devices' own damping absorbs, as in
  /// PassivityController. Unit: [J].
  double net() const { return net_; }
  double most() const { return most_; }        ///< of that, ever
  double largest() const { return largest_; }  ///< force. Unit: [N].

 private:
  /// Far above the plane: 3 cm apart, then 6 mm into each other, three times.
  static HandPath path(std::size_t hand) {
    return [side = hand == 0 ? -1.0 : 1.0](double t) {
      const double in = t < 1.0 ? 0.0 : 0.5 - 0.5 * std::cos(2.0 * M_PI * (t - 1.0));
      Pose pose;
      pose.position = {side * (0.015 - 0.008 * in), 0.0, 1.0};
      return pose;
    };
  }

  Hands hands_;
  ToolTracker tracker_;
  std::vector<std::unique_ptr<SimulatedDevice>> devices_;
  std::vector<std::unique_ptr<ServoTick>> loops_;
  TickRecord records_[2];
  double net_ = 0.0, most_ = 0.0, largest_ = 0.0;
};

TEST(MutualTouch, MakesNoEnergy) {
  Pressed pressed;
  pressed.run(4.2);
  EXPECT_GT(pressed.largest(), 0.5);
  EXPECT_LT(pressed.net(), 0.0);
  EXPECT_LT(pressed.most(), 1e-6);
}

}  // namespace
}  // namespace palpate::test

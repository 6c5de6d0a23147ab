// The paper's force, eqs. 7-11, against numbers worked out by hand.

#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/haptics/density_force.h>
#include <palpate/haptics/tool.h>
#include <support/allocation_guard.h>

namespace palpate {
namespace {

using test::AllocationGuard;

Contact contact(const Eigen::Vector3d& center, double k_min, double opacity) {
  Contact c;
  c.k_min = k_min;
  c.opacity = opacity;
  c.center = center;
  // What the model must not use: it is the paper's, and knows centres only.
  c.point.setConstant(std::nan(""));
  c.normal.setConstant(std::nan(""));
  c.depth = std::nan("");
  return c;
}

std::vector<Contact> list(std::vector<Contact> all) { return all; }

ContactSet contacts(std::vector<Contact> list) {
  ContactSet set;
  set.contacts = std::move(list);
  return set;
}

/// The tool at the origin.
ForceInput input(const ContactSet& set, double dt = 0.0,
                 const Eigen::Vector3d& velocity = Eigen::Vector3d::Zero()) {
  ForceInput in;
  in.velocity.linear = velocity;
  in.dt = dt;
  in.contacts = &set;
  return in;
}

/// Parameters with round numbers and no filter.
DensityParameters plain() {
  DensityParameters p;
  p.k_base = 2.0;
  p.damping = 3.0;
  p.f_max = 100.0;
  p.tau_direction = p.tau_opacity = p.tau_velocity = 0.0;
  return p;
}

constexpr double kClose = 1e-14;

// Eq. 7 for K = 0.2 and 0.7, max 0.7: weights e^-0.5 = 0.6065306597126334 and 1, their sum
// 1.6065306597126334, so w = 0.3775406687981454 and 0.6224593312018546.
// Eq. 8: x = 0.3775406687981454 * 1 + 0.6224593312018546 * 3 = 2.2449186624037091, y = 0.3775... * 2.
// alpha_raw = 0.3775406687981454 * 0.5 + 0.6224593312018546 * 0.9 = 0.7489837324807418.
TEST(WeightedContact, IsTheSoftmaxOfKMin) {
  const WeightedContact w =
      weighted_contact(list({contact({1, 2, 0}, 0.2, 0.5), contact({3, 0, 0}, 0.7, 0.9)}));
  EXPECT_NEAR(w.centroid.x(), 2.2449186624037091, kClose);
  EXPECT_NEAR(w.centroid.y(), 0.7550813375962909, kClose);
  EXPECT_EQ(w.centroid.z(), 0.0);
  EXPECT_NEAR(w.opacity, 0.7489837324807418, kClose);
}

TEST(WeightedContact, OfEqualDepthIsTheMean) {
  const WeightedContact w = weighted_contact(
      list({contact({0, 0, 0}, 0.4, 0.2), contact({3, 0, 0}, 0.4, 0.5), contact({0, 3, 3}, 0.4, 0.8)}));
  EXPECT_NEAR((w.centroid - Eigen::Vector3d(1, 1, 1)).norm(), 0.0, kClose);
  EXPECT_NEAR(w.opacity, 0.5, kClose);
}

TEST(WeightedContact, OfOneIsItself) {
  const WeightedContact w = weighted_contact(list({contact({1, 2, 3}, 0.01, 0.3)}));
  EXPECT_EQ(w.centroid, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(w.opacity, 0.3);
}

// Eqs. 9-11: k_eff = 2 * 0.7489837324807418, N = 2: 2.9959349299229672 N, along -p_eff / |p_eff| with
// |p_eff| = sqrt(2.2449186624037091^2 + 0.7550813375962909^2) = 2.3685...
TEST(DensityForce, PushesTheToolAwayFromTheCentroid) {
  DensityForce model(plain());
  const ContactSet set = contacts({contact({1, 2, 0}, 0.2, 0.5), contact({3, 0, 0}, 0.7, 0.9)});
  const Wrench wrench = model.evaluate(input(set)).wrench;
  EXPECT_NEAR(wrench.force.norm(), 2.9959349299229672, kClose);
  EXPECT_NEAR(
      (wrench.force.normalized() + Eigen::Vector3d(2.2449186624037091, 0.7550813375962909, 0).normalized())
          .norm(),
      0.0, kClose);
  EXPECT_LT(wrench.force.x(), 0.0);
  EXPECT_EQ(wrench.torque, Eigen::Vector3d::Zero());
}

TEST(DensityForce, DirectionIsFromTheToolNotFromTheOrigin) {
  DensityForce model(plain());
  const ContactSet set = contacts({contact({1, 1, 1}, 0.5, 1.0)});
  ForceInput in = input(set);
  in.tool.position << 1, 1, 4;  // three above: the push is up, 2 * 1 * 1
  EXPECT_NEAR((model.evaluate(in).wrench.force - Eigen::Vector3d(0, 0, 2)).norm(), 0.0, kClose);
}

TEST(DensityForce, ElasticForceGrowsWithTheNumberAndTheOpacity) {
  for (const std::size_t n : {1U, 2U, 10U}) {
    for (const double alpha : {0.25, 0.5, 1.0}) {
      DensityForce model(plain());
      const ContactSet set = contacts(std::vector<Contact>(n, contact({0, 0, -1}, 0.5, alpha)));
      // k_base alpha N, upwards.
      EXPECT_NEAR((model.evaluate(input(set)).wrench.force -
                   Eigen::Vector3d(0, 0, 2.0 * alpha * static_cast<double>(n)))
                      .norm(),
                  0.0, 1e-13);
    }
  }
}

// Outward is +z; 2 contacts of opacity 1: elastic 4 N. D = 3 N s/m.
TEST(DensityForce, DampingAddsOnTheWayInAndSubtractsOnTheWayOut) {
  const ContactSet set = contacts({contact({0, 0, -1}, 0.5, 1.0), contact({0, 0, -2}, 0.5, 1.0)});
  const auto force_at = [&](const Eigen::Vector3d& velocity) {
    return DensityForce(plain()).evaluate(input(set, 0.0, velocity)).wrench.force;
  };
  EXPECT_NEAR((force_at({0, 0, -0.5}) - Eigen::Vector3d(0, 0, 5.5)).norm(), 0.0, kClose);  // 4 + 3 * 0.5
  EXPECT_NEAR((force_at({0, 0, 0.5}) - Eigen::Vector3d(0, 0, 2.5)).norm(), 0.0, kClose);   // 4 - 3 * 0.5
  EXPECT_NEAR((force_at({7, 9, 0}) - Eigen::Vector3d(0, 0, 4)).norm(), 0.0, kClose);  // sliding costs nothing
  EXPECT_EQ(force_at({0, 0, 2.0}), Eigen::Vector3d::Zero());                          // 4 - 6: never pulls
  EXPECT_NEAR((force_at({0, 0, -1000.0}) - Eigen::Vector3d(0, 0, 100)).norm(), 0.0, 1e-13);  // F_max
  ForceInput weak = input(set, 0.0, {0, 0, -0.5});
  weak.damping_max = 1.0;  // of a device that can render less
  EXPECT_NEAR(DensityForce(plain()).evaluate(weak).wrench.force.z(), 4.5, kClose);
  const Tool two({{"first", Eigen::Vector3d::Ones(), {}}, {"second", Eigen::Vector3d::Ones(), {}}});
  EXPECT_NEAR(DensityForce(two, plain()).evaluate(weak).wrench.force.z(), 4.25, kClose)
      << "half for each part";
}

TEST(DensityForce, IsClampedToTheDevice) {
  DensityParameters p = plain();
  p.f_max = 5.0;
  DensityForce model(p);
  const ContactSet set = contacts(std::vector<Contact>(40, contact({0, 3, 4}, 0.5, 1.0)));  // 80 N
  EXPECT_NEAR((model.evaluate(input(set)).wrench.force - Eigen::Vector3d(0, -3, -4)).norm(), 0.0, kClose);
}

TEST(DensityForce, IsZeroWithoutContact) {
  DensityForce model(plain());
  const ContactSet none;
  const Wrench wrench = model.evaluate(input(none, 0.001, {0, 0, -1})).wrench;
  EXPECT_EQ(wrench.force, Eigen::Vector3d::Zero());
  EXPECT_EQ(wrench.torque, Eigen::Vector3d::Zero());
}

// One above, one below, alike: there is no way out to push to.
TEST(DensityForce, IsZeroAndNotNanBetweenSymmetricContacts) {
  DensityForce model(plain());
  const ContactSet set = contacts({contact({0, 0, 1}, 0.5, 1.0), contact({0, 0, -1}, 0.5, 1.0)});
  EXPECT_EQ(model.evaluate(input(set, 0.0, {1, 2, 3})).wrench.force, Eigen::Vector3d::Zero());
  EXPECT_EQ(model.evaluate(input(set, 0.001, {1, 2, 3})).wrench.force, Eigen::Vector3d::Zero());
  const ContactSet at_centre = contacts({contact({0, 0, 0}, 1.0, 1.0)});
  EXPECT_EQ(DensityForce(plain()).evaluate(input(at_centre)).wrench.force, Eigen::Vector3d::Zero());
}

// Opacity 1 for the first call, 0 from then on, tau = 10 ms: alpha(t) = e^(-t/tau).
TEST(DensityForce, OpacityIsAveragedInTime) {
  DensityParameters p = plain();
  p.tau_opacity = 0.01;
  const ContactSet dense = contacts({contact({0, 0, -1}, 0.5, 1.0)});
  const ContactSet thin = contacts({contact({0, 0, -1}, 0.5, 0.0)});
  const auto after = [&](const std::vector<double>& steps) {
    DensityForce model(p);
    EXPECT_NEAR(model.evaluate(input(dense)).wrench.force.z(), 2.0, kClose);  // begins at the first value
    double force = 0.0;
    for (const double dt : steps) force = model.evaluate(input(thin, dt)).wrench.force.z();
    return force;
  };
  EXPECT_NEAR(after({0.005}), 2.0 * std::exp(-0.5), kClose);
  EXPECT_NEAR(after({0.01}), 2.0 * std::exp(-1.0), kClose);
  EXPECT_NEAR(after({0.005, 0.005}), after({0.01}), kClose);  // time, not ticks
  EXPECT_NEAR(after({0.001, 0.002, 0.003, 0.004}), after({0.01}), kClose);
  EXPECT_NEAR(after({0.0}), 2.0, kClose);
  EXPECT_NEAR(after({1000.0}), 0.0, kClose);
}

// From straight up to straight along x, tau = 10 ms: after dt the sum is (1-b) z + b x, b = 1 - e^(-dt/tau),
// made a unit vector again.
TEST(DensityForce, DirectionIsAveragedInTimeAndIsAUnitVector) {
  DensityParameters p = plain();
  p.tau_direction = 0.01;
  DensityForce model(p);
  const ContactSet below = contacts({contact({0, 0, -1}, 0.5, 1.0)});
  const ContactSet beside = contacts({contact({-1, 0, 0}, 0.5, 1.0)});
  EXPECT_NEAR((model.evaluate(input(below)).wrench.force - Eigen::Vector3d(0, 0, 2)).norm(), 0.0, kClose);
  const double b = 1.0 - std::exp(-0.4);
  const Eigen::Vector3d expected = 2.0 * Eigen::Vector3d(b, 0, 1.0 - b).normalized();
  EXPECT_NEAR((model.evaluate(input(beside, 0.004)).wrench.force - expected).norm(), 0.0, 1e-14);
  EXPECT_NEAR((model.evaluate(input(beside, 10.0)).wrench.force - Eigen::Vector3d(2, 0, 0)).norm(), 0.0,
              1e-14);
}

// Two half steps against one: renormalising in between makes them differ, but only in second order.
TEST(DensityForce, DirectionHardlyDependsOnTheTickRate) {
  DensityParameters p = plain();
  p.tau_direction = 0.01;
  const ContactSet below = contacts({contact({0, 0, -1}, 0.5, 1.0)});
  const ContactSet aside = contacts({contact({-0.2, 0, -1}, 0.5, 1.0)});  // 11 degrees
  DensityForce fine(p), coarse(p);
  fine.evaluate(input(below));
  coarse.evaluate(input(below));
  Eigen::Vector3d one, other;
  for (int i = 0; i < 10; ++i) one = fine.evaluate(input(aside, 0.001)).wrench.force;
  other = coarse.evaluate(input(aside, 0.01)).wrench.force;
  EXPECT_LE(std::acos(std::min(1.0, one.normalized().dot(other.normalized()))), 1e-3);
}

TEST(DensityForce, OppositeDirectionsDoNotMakeNan) {
  DensityParameters p = plain();
  p.tau_direction = 1.0;
  DensityForce model(p);
  const ContactSet below = contacts({contact({0, 0, -1}, 0.5, 1.0)});
  const ContactSet above = contacts({contact({0, 0, 1}, 0.5, 1.0)});
  model.evaluate(input(below));
  for (int i = 0; i < 5; ++i)
    EXPECT_TRUE(model.evaluate(input(above, std::log(2.0))).wrench.force.allFinite());
}

// Velocity 0 at first, then 1 m/s inwards, tau = 5 ms: v(t) = 1 - e^(-t/tau).
TEST(DensityForce, VelocityIsFiltered) {
  DensityParameters p = plain();
  p.tau_velocity = 0.005;
  const ContactSet set = contacts({contact({0, 0, -1}, 0.5, 1.0)});
  const auto after = [&](const std::vector<double>& steps) {
    DensityForce model(p);
    model.evaluate(input(set));
    double force = 0.0;
    for (const double dt : steps) force = model.evaluate(input(set, dt, {0, 0, -1})).wrench.force.z();
    return force;
  };
  EXPECT_NEAR(after({0.001}), 2.0 + 3.0 * (1.0 - std::exp(-0.2)), kClose);
  EXPECT_NEAR(after({0.002}), after({0.001, 0.001}), kClose);
  EXPECT_NEAR(after({10.0}), 5.0, kClose);
}

TEST(DensityForce, WithoutTimeConstantsOnlyTheMomentCounts) {
  const ContactSet before = contacts({contact({0.3, 0, 0}, 0.1, 0.9)}),
                   now = contacts({contact({0, 0, -0.2}, 0.4, 0.5)});
  const ForceInput moment = input(now, 1e-3, {0.1, 0.2, -0.3});
  DensityForce model(plain()), fresh(plain());
  model.evaluate(input(before, 1e-3, {1.0, 2.0, 3.0}));
  const Wrench felt = model.evaluate(moment).wrench, alone = fresh.evaluate(moment).wrench;
  EXPECT_LT((felt.force - alone.force).norm(), kClose);
  EXPECT_GT(alone.force.norm(), 0.5);
}

TEST(DensityForce, TheFirstVelocityCountsInFull) {
  DensityParameters p = plain();
  p.tau_velocity = 1e9;
  const ContactSet set = contacts({contact({0, 0, -1}, 0.5, 1.0)});
  EXPECT_NEAR(DensityForce(p).evaluate(input(set, 0.001, {0, 0, -1})).wrench.force.z(), 5.0, kClose);
}

// The velocity filter runs on in the air, so that the first touch meets the velocity of the approach.
TEST(DensityForce, VelocityIsFollowedWithoutContact) {
  DensityParameters p = plain();
  p.tau_velocity = 0.005;
  DensityForce model(p);
  const ContactSet none, set = contacts({contact({0, 0, -1}, 0.5, 1.0)});
  model.evaluate(input(none));
  model.evaluate(input(none, 0.005, {0, 0, -1}));
  const double v = 1.0 - std::exp(-2.0);  // two time constants after standstill
  EXPECT_NEAR(model.evaluate(input(set, 0.005, {0, 0, -1})).wrench.force.z(), 2.0 + 3.0 * v, kClose);
}

TEST(DensityForce, ForgetsDirectionAndOpacityAtTheEndOfAContact) {
  DensityParameters p = plain();
  p.tau_direction = p.tau_opacity = 1e9;
  DensityForce model(p);
  const ContactSet below = contacts({contact({0, 0, -1}, 0.5, 0.25)});
  const ContactSet beside = contacts({contact({-1, 0, 0}, 0.5, 1.0)});
  const ContactSet none;
  EXPECT_NEAR((model.evaluate(input(below)).wrench.force - Eigen::Vector3d(0, 0, 0.5)).norm(), 0.0, kClose);
  EXPECT_NEAR((model.evaluate(input(beside, 0.001)).wrench.force - Eigen::Vector3d(0, 0, 0.5)).norm(), 0.0,
              1e-9);  // remembers
  EXPECT_EQ(model.evaluate(input(none, 0.001)).wrench.force, Eigen::Vector3d::Zero());
  EXPECT_NEAR((model.evaluate(input(beside, 0.001)).wrench.force - Eigen::Vector3d(2, 0, 0)).norm(), 0.0,
              kClose);
}

TEST(DensityForce, ResetForgetsAllButTheParameters) {
  DensityParameters p = plain();
  p.tau_direction = p.tau_opacity = p.tau_velocity = 1e9;
  DensityForce used(p);
  const ContactSet below = contacts({contact({0, 0, -1}, 0.5, 0.25)});
  const ContactSet beside = contacts({contact({-1, 0, 0}, 0.5, 1.0)});
  used.evaluate(input(below, 0.001, {0, 0, 5}));
  used.reset();
  const Wrench after = used.evaluate(input(beside, 0.001, {-1, 0, 0})).wrench;
  EXPECT_NEAR((after.force - Eigen::Vector3d(5, 0, 0)).norm(), 0.0, kClose);  // 2 + 3, as a new one
  EXPECT_EQ(after.force, DensityForce(p).evaluate(input(beside, 0.001, {-1, 0, 0})).wrench.force);
}

TEST(DensityForce, TurnsAndMovesWithTheWorld) {
  const Eigen::Matrix3d R = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.2).normalized().toRotationMatrix();
  const Eigen::Vector3d t(1.5, -2.0, 0.25);
  DensityForce one, other;
  for (int i = 0; i < 20; ++i) {
    const double s = 0.1 * i;
    const ContactSet here =
        contacts({contact({std::sin(s), -1, 0.1}, 0.3 + 0.02 * i, 0.9), contact({0.2, -1, s}, 0.6, 0.4)});
    ContactSet there = here;
    for (Contact& c : there.contacts) c.center = R * c.center + t;
    const Eigen::Vector3d velocity(0.1, -0.2 + 0.01 * i, 0.05);
    const ForceInput in = input(here, 0.001, velocity);
    ForceInput turned = input(there, 0.001, R * velocity);
    turned.tool.position = t;
    EXPECT_NEAR((R * one.evaluate(in).wrench.force - other.evaluate(turned).wrench.force).norm(), 0.0, 1e-13);
  }
}

TEST(DensityForce, DoesNotAllocate) {
  DensityForce model;
  const ContactSet set = contacts(std::vector<Contact>(100, contact({0, 0, -1}, 0.5, 1.0)));
  const ContactSet none;
  const AllocationGuard guard;
  for (int i = 0; i < 10; ++i) model.evaluate(input(i % 3 == 0 ? none : set, 0.001, {0, 0, -1}));
  model.reset();
  EXPECT_EQ(guard.count(), 0U);
}

TEST(AllocationGuard, SeesWhatAllocates) {
  const AllocationGuard guard;
  const auto number = std::make_unique<int>(7);
  const std::vector<double> numbers(100, static_cast<double>(*number));
  const std::string text(100, static_cast<char>('a' + numbers.size() % 7));
  // A compiler may leave out what nobody sees.
  [[maybe_unused]] const void* volatile seen = number.get();
  seen = numbers.data();
  seen = text.data();
  EXPECT_GE(guard.count(), 3U);
}

TEST(DensityForce, PushesEveryPartOfATool) {
  const Eigen::Quaterniond quarter(std::sqrt(0.5), 0, 0, std::sqrt(0.5));  // x to y
  const Tool tool({{"left", {1, 1, 1}, {{-2, 0, 0}, Eigen::Quaterniond::Identity()}},
                   {"right", {1, 1, 1}, {{2, 0, 0}, Eigen::Quaterniond::Identity()}}});
  DensityForce model(tool, plain());
  // Turned, the right part is at (0, 2, 0) and the left one at (0, -2, 0). One contact below the right part:
  // k_base alpha = 2 * 0.5 upwards there, and a torque (0, 2, 0) x (0, 0, 1) = (2, 0, 0).
  Contact below = contact({0, 2, -1}, 0.4, 0.5);
  below.part = 1;
  const ContactSet set = contacts({below});
  ForceInput in = input(set);
  in.tool.orientation = quarter;
  const Wrench one = model.evaluate(in).wrench;
  EXPECT_NEAR((one.force - Eigen::Vector3d(0, 0, 1)).norm(), 0.0, kClose);
  EXPECT_NEAR((one.torque - Eigen::Vector3d(2, 0, 0)).norm(), 0.0, kClose);
  // Below both: the forces add, the torques cancel.
  const ContactSet both = contacts({contact({0, -2, -1}, 0.4, 0.5), below});
  in.contacts = &both;
  model.reset();
  const Wrench two = model.evaluate(in).wrench;
  EXPECT_NEAR((two.force - Eigen::Vector3d(0, 0, 2)).norm(), 0.0, kClose);
  EXPECT_NEAR(two.torque.norm(), 0.0, kClose);
}

// A part 2 m from the handle, which is still, goes down at 0.1 m/s where the tool turns by 0.05 rad/s about y
// ((0, 0.05, 0) x (2, 0, 0) = (0, 0, -0.1)): damping adds 3 * 0.1 to 2 * 0.5. On the other side it goes up.
TEST(DensityForce, DampsHowFastAPartGoesWhereTheToolTurns) {
  for (const double side : {1.0, -1.0}) {
    const Tool tool({{"aside", {1, 1, 1}, {{2.0 * side, 0, 0}, Eigen::Quaterniond::Identity()}}});
    DensityForce model(tool, plain());
    const ContactSet set = contacts({contact({2.0 * side, 0, -1}, 0.4, 0.5)});
    ForceInput in = input(set);
    in.velocity.angular = {0, 0.05, 0};
    EXPECT_NEAR(model.evaluate(in).wrench.force.z(), 1.0 + side * 0.3, kClose);
  }
}

TEST(DensityForce, HasNoProxyAndNoPotentialAndIsSureOfWhatItFeels) {
  const ContactSet set = contacts({contact({0, 0, -1}, 0.4, 0.5)});
  DensityForce model(Tool({1, 1, 1}), plain());
  ForceInput in = input(set);
  in.tool.position = {0.1, 0.2, 0.3};
  const ForceOutput felt = model.evaluate(in);
  EXPECT_EQ(felt.proxy.position, in.tool.position);
  EXPECT_EQ(felt.confidence, 1.0);
  EXPECT_TRUE(std::isnan(felt.stored_energy));
}

TEST(DensityForce, OfManyPartsIsClampedAsAWhole) {
  DensityParameters p = plain();
  p.f_max = 1.5;
  const Tool tool({{"left", {1, 1, 1}, {{-2, 0, 0}, Eigen::Quaterniond::Identity()}},
                   {"right", {1, 1, 1}, {{2, 0, 0}, Eigen::Quaterniond::Identity()}}});
  DensityForce model(tool, p);
  Contact right = contact({2, 0, -1}, 0.4, 0.5);
  right.part = 1;
  const ContactSet both = contacts({contact({-2, 0, -1}, 0.4, 0.5), right});
  EXPECT_NEAR((model.evaluate(input(both)).wrench.force - Eigen::Vector3d(0, 0, 1.5)).norm(), 0.0, kClose);
  // However little it is too much: of 1 N on each, 1.95 N.
  p.f_max = 1.95;
  DensityForce hardly(tool, p);
  EXPECT_NEAR((hardly.evaluate(input(both)).wrench.force - Eigen::Vector3d(0, 0, 1.95)).norm(), 0.0, kClose);
  // The torque is of the force that is felt: 1 N at 2 m and at 4 m, of which three quarters are left.
  const Eigen::Quaterniond straight = Eigen::Quaterniond::Identity();
  p.f_max = 1.5;
  DensityForce aside(
      Tool({{"near", {1, 1, 1}, {{2, 0, 0}, straight}}, {"far", {1, 1, 1}, {{4, 0, 0}, straight}}}), p);
  Contact far = contact({4, 0, -1}, 0.4, 0.5);
  far.part = 1;
  const ContactSet pushes = contacts({contact({2, 0, -1}, 0.4, 0.5), far});
  EXPECT_NEAR((aside.evaluate(input(pushes)).wrench.torque - Eigen::Vector3d(0, -4.5, 0)).norm(), 0.0,
              kClose);
}

}  // namespace
}  // namespace palpate

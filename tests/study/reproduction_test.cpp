// The paper's evaluation, on a sphere of which depth and direction are known.
#include <palpate/study/reproduction_claims.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include <gmock/gmock.h>

#include <palpate/collision/paper_pipeline.h>
#include <palpate/device/giant_plant.h>
#include <palpate/haptics/density_force.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/kinematics/chain_file.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kContactStiffness = 500.0;

/// A sphere of R 0.15 m beside where the handle rests, with two places to touch.
class Sphere {
 public:
  Sphere() {
    setup_.chain = driven_chain(giant_chain(), hand_);
    setup_.hand = hand_;
    setup_.contact_stiffness = kContactStiffness;
    const Pose home = rest_of_handle(setup_.chain);
    placed_.translation = home.position + Vector3d(0.0, -0.5, 0.0);
    index_ = std::make_unique<SceneIndex>(made_, SceneFilter{}, placed_);
    FilterReport report;
    kept_ = filter_scene(made_, {}, placed_, report);
    paper_ =
        std::make_unique<PaperPipeline>(kept_, PaperPipeline::default_search_radius(kept_, tool_.radius()));
    RoomPathOptions way;
    way.touches = 2;
    way.home = home;
    way.reach = giant_reach();
    way.press = 0.015;
    path_ = room_path(*index_, kept_, tool_, way);
  }

  ReproductionRun run(bool own, ReproductionDevice device, double stall = 0.0) const {
    ReproductionModel model;
    model.stall = stall;
    if (own) {
      model.name = "proxy";
      model.force = std::make_unique<ProxyForce>(*index_, tool_, ProxyParameters{kContactStiffness});
    } else {
      model.name = "density";
      model.force = std::make_unique<DensityForce>(tool_, DensityParameters{});
      model.contacts = paper_.get();
    }
    const ReproductionScene scene{index_.get(), &kept_, paper_.get(), surface_.get(), placed_};
    const auto plant = [](const GiantSetup& setup, HandPath hand) -> std::unique_ptr<JointPlant> {
      return std::make_unique<GiantPlant>(setup.chain, GiantProperties().drives,
                                          GripProperties{setup.hand, 0.05}, std::move(hand));
    };
    return reproduce(scene, tool_, path_, std::move(model), device, setup_, plant);
  }

  const RoomPath& path() const { return path_; }
  const GiantSetup& setup() const { return setup_; }

 private:
  HandProperties hand_{0.15, 4.0, 400.0};
  GiantSetup setup_;
  Tool tool_{Vector3d::Constant(0.02)};
  std::unique_ptr<AnalyticSurface> surface_ = make_surface("sphere");
  GaussianScene made_ = make_scene(*surface_, {});
  Similarity placed_;
  std::unique_ptr<SceneIndex> index_;
  EllipsoidScene kept_;
  std::unique_ptr<PaperPipeline> paper_;
  RoomPath path_;
};

const Sphere& sphere() {
  static const Sphere made;
  return made;
}

TEST(Reproduction, FeelsTheTrueSurfaceOnBothDevices) {
  for (const auto device : {ReproductionDevice::kAdmittance, ReproductionDevice::kImpedance}) {
    SCOPED_TRACE(to_string(device));
    const ReproductionRun run = sphere().run(true, device);
    EXPECT_THAT(run.faults, testing::IsEmpty());
    EXPECT_EQ(run.held_ticks, 0U);
    EXPECT_LT(run.port_energy, 1e-3);
    ASSERT_EQ(run.contacts.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      const ReproductionContact& contact = run.contacts[i];
      const RoomTouch& touch = sphere().path().touches[i];
      EXPECT_GT(contact.begins, touch.begins);
      EXPECT_LT(contact.begins, touch.pressed);
      // Two springs in a row: the hand's, that wants to be 15 mm deep, and the scene's.
      EXPECT_NEAR(contact.force, 0.015 * 400.0 * kContactStiffness / (400.0 + kContactStiffness), 0.3);
      EXPECT_NEAR(contact.user, contact.force, 0.05 * contact.force);
      EXPECT_NEAR(contact.force, kContactStiffness * contact.depth, 0.1 * contact.force);
      EXPECT_LT(contact.off, 5.0 * std::numbers::pi / 180.0);
      EXPECT_LT(contact.swing, 5e-5);
      EXPECT_EQ(contact.bounces, 0);
    }
  }
}

TEST(Reproduction, AForceThatIsHeldLetsThePortPutOutEnergy) {
  const ReproductionRun prompt = sphere().run(true, ReproductionDevice::kImpedance);
  const ReproductionRun late = sphere().run(true, ReproductionDevice::kImpedance, 0.05);
  EXPECT_GT(late.contacts[0].overshoot, 5.0 * prompt.contacts[0].overshoot);
  EXPECT_GT(late.port_energy, 10e-3);
}

TEST(Reproduction, CountsAndTimesThePapersPipeline) {
  const ReproductionRun run = sphere().run(false, ReproductionDevice::kAdmittance);
  std::size_t in_contact = 0;
  for (const ReproductionTick& tick : run.ticks) {
    EXPECT_LE(tick.filtered, tick.candidates);
    EXPECT_LE(tick.colliding, tick.filtered);
    EXPECT_GE(tick.cpu_us, 0.0);
    if (tick.colliding == 0) {
      EXPECT_EQ(tick.felt.norm(), 0.0);
    }
    in_contact += static_cast<std::size_t>(tick.colliding > 0);
  }
  EXPECT_GT(in_contact, 3000U);  // two holds of 1.5 s
}

Claim by(Claim::Bound bound, double limit) { return {"", "", "", bound, limit, 0.0, 0.0}; }

TEST(Claims, HoldWithinTheirBound) {
  const Claim quick = by(Claim::Bound::kAtMost, 50.0);
  EXPECT_TRUE(quick.holds(50.0));
  EXPECT_FALSE(quick.holds(50.1));
  EXPECT_DOUBLE_EQ(quick.ratio(2.0), 25.0);
  const Claim many = by(Claim::Bound::kAtLeast, 7.0);
  EXPECT_TRUE(many.holds(7.0));
  EXPECT_FALSE(many.holds(6.0));
  EXPECT_DOUBLE_EQ(many.ratio(14.0), 2.0);
  EXPECT_TRUE(std::isnan(by(Claim::Bound::kAtMost, 0.0).ratio(0.0)));
  EXPECT_FALSE(quick.holds(std::numeric_limits<double>::quiet_NaN()));
}

ReproductionTick tick_of(double t, std::size_t colliding, double force, double cpu_us) {
  ReproductionTick tick;
  tick.t = t;
  tick.tool = {t, 2.0 * t, 0.0};
  tick.candidates = 10 * colliding;
  tick.colliding = colliding;
  tick.felt = tick.force = {0.0, 0.0, force};
  tick.user = {0.0, 0.0, colliding > 0 ? -3.0 : -1.0};
  tick.cpu_us = cpu_us;
  return tick;
}

/// Seven ticks, worked by hand: with a force before anything collides, and one, in the same contact, after.
ReproductionRun seven_ticks() {
  ReproductionRun run;
  run.ticks = {tick_of(0.0, 0, 0.0, 1.0),  tick_of(0.5, 0, 0.125, 1.0),  tick_of(1.0, 1, 0.5, 10.0),
               tick_of(2.0, 2, 1.0, 20.0), tick_of(3.0, 4, 4.0, 2000.0), tick_of(4.0, 3, 3.0, 30.0),
               tick_of(5.0, 0, 0.25, 1.0)};
  ReproductionContact contact;
  contact.begins = 1.0;
  contact.user = 3.0;
  contact.off = std::numbers::pi / 18.0;
  contact.bounces = 0;
  contact.swing = 1e-5;
  run.contacts = {contact};
  return run;
}

TEST(Claims, AreMeasuredAsTheySay) {
  RoomPath path;
  path.touches.resize(1);
  path.touches[0].pressed = 3.0;
  const std::vector<Claim> all = claims(2'500'000, 1'000'000, path, seven_ticks(), seven_ticks());
  const auto value = [&](const char* words) {
    for (const Claim& claim : all) {
      if (claim.words.find(words) != std::string::npos) return claim.own;
    }
    ADD_FAILURE() << words;
    return 0.0;
  };
  EXPECT_DOUBLE_EQ(value("contains 2.5 million"), 2.5);
  EXPECT_DOUBLE_EQ(value("area of"), 50.0);
  EXPECT_DOUBLE_EQ(value("Seven contact"), 1.0);
  EXPECT_DOUBLE_EQ(value("less than 500"), 40.0);
  EXPECT_DOUBLE_EQ(value("up to 100"), 4.0);
  EXPECT_DOUBLE_EQ(value("No repulsion"), 0.125);
  EXPECT_DOUBLE_EQ(value("single collisions"), 0.5 / 4.0);
  EXPECT_DOUBLE_EQ(value("increasing collision count"), 1.0);
  EXPECT_NEAR(value("direction depends"), 10.0, 1e-9);
  EXPECT_DOUBLE_EQ(value("spikes"), 3.0);
  EXPECT_DOUBLE_EQ(value("oscillatory"), 0.0);
  EXPECT_DOUBLE_EQ(value("up to 50 ms"), 2.0);
  EXPECT_DOUBLE_EQ(value("first contact points"), 0.01);
}

/// The statement says seven, however many places the path has.
TEST(Claims, AreSevenContactsOnAnyPath) {
  for (const std::size_t places : {2U, 7U, 9U}) {
    for (const std::size_t felt : {std::size_t{2}, places - 1, places}) {
      RoomPath path;
      path.touches.resize(places);
      ReproductionRun run = seven_ticks();
      run.contacts.assign(places, ReproductionContact());
      for (std::size_t k = 0; k < places; ++k)
        run.contacts[k].begins = k < felt ? 1.0 : std::numeric_limits<double>::quiet_NaN();
      const std::vector<Claim> all = claims(1, 1, path, run, run);
      const auto seven = std::find_if(all.begin(), all.end(), [](const Claim& c) { return c.figure == "7"; });
      ASSERT_NE(seven, all.end());
      EXPECT_EQ(seven->own, static_cast<double>(felt));
      EXPECT_EQ(seven->holds(seven->own), felt >= 7) << felt << " of " << places;
    }
  }
}

TEST(GiantReach, CanBeReachedAtEveryCorner) {
  const SerialChain& chain = sphere().setup().chain;
  const Eigen::AlignedBox3d reach = giant_reach();
  for (int corner = 0; corner < 8; ++corner) {
    JointMotion joints(chain);
    const Pose home = joints.tip();
    const Vector3d goal = reach.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    Pose target = home;
    constexpr int kSteps = 8000;
    for (int i = 1; i <= kSteps; ++i) {
      target.position = home.position + (goal - home.position) * i / kSteps;
      joints.step(target, 1e-3);
    }
    for (int i = 0; i < 1000; ++i) joints.step(target, 1e-3);
    EXPECT_LT((joints.tip().position - goal).norm(), 3e-3) << goal.transpose();
  }
}

}  // namespace
}  // namespace palpate

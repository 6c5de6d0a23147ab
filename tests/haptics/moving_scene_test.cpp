// The proxy in a scene that is replaced under it: one that moves, and one that is fitted anew.

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/haptics/proxy_force.h>
#include <palpate/haptics/tool_file.h>
#include <palpate/study/procedural.h>
#include <support/allocation_guard.h>
#include <support/ball_on_surface.h>
#include <support/effort.h>
#include <support/example_tools.h>
#include <support/smooth_places.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::kRadius;
using test::kStiffness;
using test::noisy;

Tool ball_tool() { return Tool{Vector3d::Constant(kRadius)}; }

/// A thing that moves, and a tool that stands still in its way.
class MovingThing {
 public:
  MovingThing(const std::string& shape, std::uint64_t seed, const Tool& tool = ball_tool(),
              Lookahead* lookahead = nullptr)
      : MovingThing(shape, noisy(seed), tool, lookahead) {}
  MovingThing(const std::string& shape, const ProceduralOptions& options, const Tool& tool,
              Lookahead* lookahead = nullptr, double friction = 0.0)
      : surface(make_surface(shape)),
        index_(make_scene(*surface, options), SceneFilter{}, Similarity{}),
        model_(index_, tool, {.stiffness = kStiffness, .friction = friction}, lookahead) {
    input.dt = 1e-3;
    input.contacts = &none_;
  }

  /// A tick in which the thing goes to `world_from_thing`; a copy that is registered anew.
  const ForceOutput& go_to(const Similarity& world_from_thing) {
    return become(index_.registered(world_from_thing), world_from_thing);
  }
  const ForceOutput& become(const SceneIndex& index, const Similarity& world_from_thing) {
    index_ = index;
    where_ = world_from_thing;
    return stay();
  }
  const ForceOutput& stay() { return felt_ = model_.evaluate(input); }
  /// A tick in which the tool goes to `position`.
  const ForceOutput& lead(const Vector3d& position) {
    input.tool.position = position;
    return stay();
  }
  /// The tool is at `position`, and was nowhere before.
  void put_tool(const Vector3d& position) {
    model_.reset();
    input.tool.position = position;
  }

  /// Of a point of the world, where it is to the thing.
  Vector3d in_thing(const Vector3d& point) const { return where_.inverse() * point; }
  /// From the true surface to the proxy, negative inside a solid.
  double distance() const { return surface->distance(in_thing(felt_.proxy.position)); }
  /// The way out of the true surface where the proxy is, in the world.
  Vector3d outwards() const {
    return where_.rotation * surface->project(in_thing(felt_.proxy.position)).normal;
  }
  const ForceOutput& felt() const { return felt_; }

  std::unique_ptr<AnalyticSurface> surface;
  ForceInput input;

 private:
  SceneIndex index_;
  ProxyForce model_;
  ContactSet none_;
  Similarity where_;
  ForceOutput felt_;
};

Similarity moved(const Vector3d& by) { return {1.0, Eigen::Quaterniond::Identity(), by}; }

void expect_finite(const ForceOutput& felt) {
  ASSERT_TRUE(felt.wrench.force.allFinite() && felt.wrench.torque.allFinite());
  ASSERT_TRUE(felt.proxy.position.allFinite() && std::isfinite(felt.stored_energy));
}

/// Places on a surface that a thing comes from.
constexpr int kPlaces = static_cast<int>(test::draws(12));

/// `count` balls side by side, as a plate.
Tool plate_of_balls(int count, double radius = kRadius) {
  const int side = static_cast<int>(std::ceil(std::sqrt(count)));
  std::vector<ToolPart> parts;
  for (int i = 0; i < count; ++i) {
    const Vector3d at = 1.5 * radius * Vector3d(i % side, i / side, 0.0);
    parts.push_back({"", Vector3d::Constant(radius), {at, Eigen::Quaterniond::Identity()}});
  }
  return Tool(parts);
}

class OnMovingShapes : public testing::TestWithParam<const char*> {};

// At 1 m/s and slower, until the tool's centre is as deep below the surface as the ball is thick.
TEST_P(OnMovingShapes, AThingThatMovesTowardsAStillToolPushesItAndIsNotPassed) {
  MovingThing thing(GetParam(), 41);
  Random random(42);
  for (const double step : {1e-3, 3e-4, 5e-5}) {
    for (const SurfaceSample& s : test::smooth_places(*thing.surface, GetParam(), kPlaces, 43)) {
      const Vector3d aside{random.normal(), random.normal(), random.normal()};
      const Vector3d along = (s.normal + 0.4 * aside.normalized()).normalized();
      thing.put_tool(s.point + 0.04 * along);
      const auto at = [&](double way) { return moved(way * along); };
      thing.go_to(at(0.0));
      for (double way = 0.0; way < 0.04 + 2.0 * kRadius; way += step) {
        const ForceOutput& felt = thing.go_to(at(way));
        expect_finite(felt);
        const double depth = way - 0.04 + kRadius;
        if (depth < -0.01) {
          ASSERT_EQ(felt.wrench.force.norm(), 0.0) << "ahead of it, at " << way;
        }
        ASSERT_GE(thing.distance(), 0.75 * kRadius) << "step " << step << " at " << way;
        const Vector3d proxy = thing.in_thing(felt.proxy.position);
        const NearestPoint nearest = thing.surface->project(proxy);
        const bool is_near = (nearest.point - s.point).norm() < 0.05;
        if (!thing.surface->closed() && is_near) {
          ASSERT_GT((proxy - nearest.point).dot(s.normal), 0.0) << "on the other side";
        }
        if (depth > 0.006 && is_near) {
          ASSERT_GT(felt.wrench.force.dot(thing.outwards()), 0.8 * felt.wrench.force.norm()) << way;
          ASSERT_GT(felt.wrench.force.norm(), 0.5 * kStiffness * (depth - 0.006)) << way;
        }
      }
    }
  }
}

// What is felt at the end is what a still thing has for a tool that has come to it, to within what a patch
// may be off the fit: two deviations of the noise.
TEST_P(OnMovingShapes, OnceItStandsItIsFeltAsOneThatNeverMoved) {
  constexpr double kDepth = 0.008, kStart = 0.01;
  for (const SurfaceSample& s : test::smooth_places(*make_surface(GetParam()), GetParam(), kPlaces, 44)) {
    MovingThing moves(GetParam(), 45), stands(GetParam(), 45);
    const Vector3d end = s.point + (kRadius - kDepth) * s.normal;
    moves.input.tool.position = end;
    for (double way = kStart + kDepth; way > 0.0; way -= 2e-4) {
      stands.input.tool.position = end + way * s.normal;
      stands.stay();
      moves.go_to(moved(-way * s.normal));
    }
    stands.input.tool.position = end;
    moves.go_to({});
    for (int k = 0; k < 300; ++k) {
      stands.stay();
      moves.stay();
    }
    const Vector3d expected = stands.felt().wrench.force;
    EXPECT_GT(expected.norm(), 0.3 * kStiffness * kDepth);
    EXPECT_LE((moves.felt().wrench.force - expected).norm(), kStiffness * 2.0 * 0.0015);
  }
}

TEST_P(OnMovingShapes, AThingThatGoesAwayAgainNeverPulls) {
  MovingThing thing(GetParam(), 46);
  for (const SurfaceSample& s : test::smooth_places(*thing.surface, GetParam(), kPlaces, 47)) {
    thing.put_tool(s.point + 0.03 * s.normal);
    const auto go = [&](double way) -> const ForceOutput& { return thing.go_to(moved(way * s.normal)); };
    for (double way = 0.0; way < 0.02; way += 5e-4) go(way);
    EXPECT_GT(thing.felt().wrench.force.dot(s.normal), 1.0);
    for (double way = 0.02; way > 0.0; way -= 5e-4) {
      const ForceOutput& felt = go(way);
      expect_finite(felt);
      EXPECT_GE(felt.wrench.force.dot(thing.outwards()), -1e-9);
    }
    EXPECT_EQ(thing.felt().wrench.force.norm(), 0.0);
    EXPECT_EQ(thing.felt().proxy.position, thing.input.tool.position);
  }
}

// In the frame of a thing, it is the tool that moves: the same is felt.
TEST_P(OnMovingShapes, AThingThatMovesIsFeltAsAStillOneIsByAToolThatMoves) {
  MovingThing moves(GetParam(), 61), stands(GetParam(), 61);
  Random random(62);
  double most = 0.0;
  for (const SurfaceSample& s : test::smooth_places(*moves.surface, GetParam(), kPlaces, 63)) {
    const Vector3d aside = s.normal.unitOrthogonal();
    const Vector3d about{random.normal(), random.normal(), random.normal()};
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(2.0, about.normalized()));
    moves.put_tool({0.3, -0.2, 0.1});
    stands.put_tool({});
    for (int k = 0; k < 150; ++k) {
      const Vector3d place = s.point + (kRadius + 0.01 - 2e-4 * k) * s.normal + 1e-4 * k * aside;
      const Eigen::Quaterniond turned(Eigen::AngleAxisd(1e-3 * k, s.normal));
      stands.input.tool = {place, turned};
      // The tool stays where it is and turns, the thing comes to it.
      moves.input.tool.orientation = turn * turned;
      const Similarity where{1.0, turn, moves.input.tool.position - turn * place};
      const ForceOutput &felt = moves.go_to(where), &expected = stands.stay();
      const Wrench &is = felt.wrench, &was = expected.wrench;
      ASSERT_LE((is.force - turn * was.force).norm(), 1e-6) << k;
      ASSERT_LE((is.torque - turn * was.torque).norm(), 1e-6) << k;
      ASSERT_LE((moves.in_thing(felt.proxy.position) - expected.proxy.position).norm(), 1e-9) << k;
      if (expected.proxy == stands.input.tool) {
        ASSERT_EQ(felt.proxy, moves.input.tool) << "to the last bit, " << k;
      }
      ASSERT_EQ(felt.local.count, expected.local.count) << k;
      for (std::size_t i = 0; i < felt.local.count; ++i) {
        const ContactPlane &plane = felt.local.planes[i], &same = expected.local.planes[i];
        ASSERT_LE((moves.in_thing(plane.point) - same.point).norm(), 1e-9) << k;
        ASSERT_LE((plane.normal - turn * same.normal).norm(), 1e-9) << k;
      }
      most = std::max(most, was.force.norm());
    }
  }
  EXPECT_GT(most, 0.5 * kStiffness * 0.015);
}

// Another memory a tick, with noise of its own: what is known of the one before would not fit.
TEST_P(OnMovingShapes, AThingThatIsFittedAnewKeepsTheToolOut) {
  constexpr double kDepth = 0.01;
  std::vector<SceneIndex> fits;
  const auto surface = make_surface(GetParam());
  for (std::uint64_t seed = 0; seed < 8; ++seed)
    fits.emplace_back(make_scene(*surface, noisy(100 + seed)), SceneFilter{}, Similarity{});
  MovingThing thing(GetParam(), 48);
  for (const SurfaceSample& s : test::smooth_places(*surface, GetParam(), kPlaces, 49)) {
    thing.put_tool(s.point + 0.1 * s.normal);
    for (int k = 0; k < 200; ++k) {
      const double depth = std::min(kDepth, -0.01 + 2e-4 * k);
      thing.input.tool.position = s.point + (kRadius - depth) * s.normal;
      const ForceOutput& felt = thing.become(fits[static_cast<std::size_t>(k) % fits.size()], {});
      expect_finite(felt);
      ASSERT_GE(thing.distance(), 0.75 * kRadius) << k;
      if (depth < 0.006) continue;
      ASSERT_GT(felt.wrench.force.dot(s.normal), 0.8 * felt.wrench.force.norm()) << k;
      ASSERT_GT(felt.wrench.force.norm(), 0.2 * kStiffness * depth) << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Proxy, OnMovingShapes,
                         testing::Values("sphere", "cylinder", "torus", "plane", "shell"));

// A thing that turns past the tool, with another thread that is late.
TEST(ProxyInAMovingScene, IsNotPassedWhereAnotherThreadLooksAhead) {
  for (const int rounds : {1, 7, 50}) {
    Lookahead lookahead;
    MovingThing thing("box", 51, ball_tool(), &lookahead);
    thing.input.tool.position = {0.15 + kRadius - 0.003, 0.0, 0.0};
    double most = 0.0;
    for (int k = -300; k <= 300; ++k) {
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(1e-3 * k, Vector3d::UnitZ()));
      const ForceOutput& felt = thing.go_to({1.0, turn, Vector3d::Zero()});
      expect_finite(felt);
      if (k > -300) {
        ASSERT_GE(thing.distance(), 0.75 * kRadius) << k;
      }
      most = std::max(most, felt.wrench.force.norm());
      if (k % rounds == 0) {
        lookahead.take();
        lookahead.finish();
      }
    }
    EXPECT_GT(most, 0.5 * kStiffness * 0.003);
  }
}

TEST(ProxyInAMovingScene, AToolOfSeveralPartsIsPushed) {
  for (const std::string name : {"fingertip", "gripper"}) {
    const Tool tool = read_tool(test::example_tool(name));
    MovingThing thing("plane", 52, tool);
    const double reach = tool.radius();
    for (const double step : {1e-3, 2e-4}) {
      thing.input.tool.position = {0.0, 0.0, reach + 0.02};
      thing.input.tool.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3d::UnitX()));
      thing.go_to({});
      for (int k = 0; k < 10; ++k) thing.stay();
      double last = 0.0;
      for (double way = 0.0; way < reach + 0.03; way += step) {
        const ForceOutput& felt = thing.go_to(moved({0.0, 0.0, way}));
        expect_finite(felt);
        last = felt.wrench.force.z();
        ASSERT_GE(last, -1e-9) << name << " at " << way;
      }
      EXPECT_GT(last, 0.5 * kStiffness * 0.01) << name << ", step " << step;
      for (double way = reach + 0.03; way > -0.1; way -= 1e-3) thing.go_to(moved({0.0, 0.0, way}));
    }
  }
}

// Splats 1.6 mm apart: more than a tick has time to look at, for more than one ball of this size.
TEST(ProxyInAMovingScene, ADenseSceneThatComesInEveryTickIsFeltByManyParts) {
  for (const int count : {1, 2, 8, 9, 16}) {
    MovingThing thing("plane", noisy(55, 0.0016), plate_of_balls(count));
    thing.put_tool({0.0, 0.0, kRadius + 0.01});
    thing.stay();
    for (double way = 0.0; way < 0.02; way += 2e-4) {
      const ForceOutput& felt = thing.go_to(moved({0.0, 0.0, way}));
      const double depth = way - 0.01;
      ASSERT_GE(thing.distance(), kRadius - 0.0045) << count << " at " << way;
      if (depth > 0.006) {
        ASSERT_GT(felt.wrench.force.z(), 0.6 * kStiffness * (depth - 0.003)) << count;
      }
    }
  }
}

// The same where each tick brings other Gaussians: what a tick has no time to look at is not passed either.
TEST(ProxyInAMovingScene, ADenseSceneThatIsFittedAnewInEveryTickIsFeltByManyParts) {
  const auto surface = make_surface("plane");
  std::vector<SceneIndex> fits;
  for (const std::uint64_t seed : {56, 57, 58})
    fits.emplace_back(make_scene(*surface, noisy(seed, 0.0016)), SceneFilter{}, Similarity{});
  for (const int count : {1, 2, 8, 9, 20}) {
    MovingThing thing("plane", noisy(55, 0.0016), plate_of_balls(count));
    thing.put_tool({0.0, 0.0, kRadius + 0.01});
    thing.stay();
    std::size_t tick = 0;
    for (double way = 0.0; way < 0.02; way += 2e-4) {
      const Similarity where = moved({0.0, 0.0, way});
      const ForceOutput& felt = thing.become(fits[++tick % fits.size()].registered(where), where);
      const double depth = way - 0.01;
      ASSERT_GE(thing.distance(), kRadius - 0.0045) << count << " at " << way;
      if (depth > 0.006) {
        ASSERT_GT(felt.wrench.force.z(), 0.6 * kStiffness * (depth - 0.003)) << count;
      }
    }
  }
}

// Which takes several ticks where there are many parts: none is pushed out twice.
TEST(ProxyInAMovingScene, IsNoFartherOutThanItMustBeWhereItStartsInASceneThatIsFittedAnew) {
  constexpr double kRise = 0.009, kAbove = 0.005, kDepth = kRise - kAbove;
  constexpr double kSmall = 0.01;
  MovingThing thing("plane", noisy(55, 0.0016), plate_of_balls(256, kSmall));
  const SceneIndex other(make_scene(*thing.surface, noisy(56, 0.0016)), SceneFilter{}, Similarity{});
  thing.put_tool({0.0, 0.0, kSmall + 0.005});
  thing.stay();
  // Touches it, and is free again: planes that do not hold it stay known.
  for (double depth = -0.005; depth < 0.004; depth += 1e-4) thing.lead({0.0, 0.0, kSmall - depth});
  for (double depth = 0.004; depth > -kAbove; depth -= 1e-4) thing.lead({0.0, 0.0, kSmall - depth});
  for (int k = 0; k < 50; ++k) thing.lead({0.0, 0.0, kSmall + kAbove});
  const Similarity up = moved({0.0, 0.0, kRise});
  thing.become(other.registered(up), up);
  for (int k = 0; k < 100; ++k) {
    EXPECT_GE(thing.felt().wrench.force.z(), kStiffness * 0.5 * kDepth) << k;
    ASSERT_LE(thing.felt().wrench.force.z(), kStiffness * (kDepth + 0.006)) << k;
    ASSERT_GE(thing.distance(), 0.5 * kSmall) << k;
    thing.stay();
  }
  EXPECT_GE(thing.distance(), kSmall - 0.003);
  EXPECT_GE(thing.felt().wrench.force.z(), kStiffness * (kDepth - 0.003));
}

// The part that is touched is the last of all, and has its turn.
TEST(ProxyInAMovingScene, EveryPartHasItsTurnWhereTheSceneIsFittedAnewInEveryTick) {
  constexpr double kSmall = 0.005;
  const double tilt = 0.3, low = 15.0 * 1.5 * kSmall * std::sin(tilt);  // of the last row
  const auto surface = make_surface("plane");
  std::vector<SceneIndex> fits;
  for (const std::uint64_t seed : {56, 57})
    fits.emplace_back(make_scene(*surface, noisy(seed, 0.0016)), SceneFilter{}, Similarity{});
  const Tool tool = plate_of_balls(256, kSmall);
  MovingThing thing("plane", noisy(55, 0.0016), tool);
  thing.put_tool({0.0, 0.0, low + kSmall + 0.005});
  thing.input.tool.orientation = Eigen::AngleAxisd(-tilt, Vector3d::UnitX());
  thing.stay();
  std::size_t tick = 0;
  for (double way = 0.0; way < 0.015; way += 2e-4) {
    const Similarity where = moved({0.0, 0.0, way});
    const ForceOutput& felt = thing.become(fits[++tick % fits.size()].registered(where), where);
    const Pose last = felt.proxy * tool.parts().back().pose;
    ASSERT_GE(thing.surface->distance(thing.in_thing(last.position)), 0.0) << way;
  }
  EXPECT_GT(thing.felt().wrench.force.z(), 0.5);
}

// Both friction's cone and its direction: a floor that slides under a tool at rest takes it along.
TEST(ProxyInAMovingScene, AFloorThatSlidesDragsTheToolByFriction) {
  constexpr double kFriction = 0.4, kDepth = 0.005;
  MovingThing thing("plane", ProceduralOptions{}, ball_tool(), nullptr, kFriction);
  thing.put_tool({0.0, 0.0, kRadius + 0.002});
  thing.stay();
  for (double depth = -0.002; depth < kDepth; depth += 1e-4) thing.lead({0.0, 0.0, kRadius - depth});
  for (double way = 0.0; way < 0.03; way += 1e-4) thing.go_to(moved({way, 0.0, 0.0}));
  const Vector3d force = thing.felt().wrench.force;
  EXPECT_NEAR(force.z(), kStiffness * kDepth, 0.05 * kStiffness * kDepth);
  EXPECT_NEAR(force.x(), kFriction * force.z(), 0.05 * force.z());
  EXPECT_NEAR(force.y(), 0.0, 0.02 * force.z());
}

// At 50 m/s, a tick takes a thin sheet from one side of the ball to the other.
TEST(ProxyInAMovingScene, ASheetThatComesAtAnySpeedIsNotPassed) {
  for (const double step : {0.05, 0.013, 0.003}) {
    MovingThing thing("plane", 59);
    thing.put_tool({0.0, 0.0, 0.1});
    thing.stay();
    double way = 0.0;
    for (; way < 0.15; way += step) thing.go_to(moved({0.0, 0.0, way}));
    for (int k = 0; k < 20; ++k) thing.stay();
    const double depth = way - step - 0.1 + kRadius;
    EXPECT_GE(thing.distance(), kRadius - 0.0045) << step;
    EXPECT_NEAR(thing.felt().wrench.force.z(), kStiffness * depth, kStiffness * 0.0045) << step;
  }
}

// Once it is out of what there is now, the proxy moves no farther in a tick than the tool and a little.
TEST(ProxyInAMovingScene, IsNoFasterOnceItIsOut) {
  constexpr double kStep = 1e-4, kLittle = 1e-4;
  MovingThing thing("step", 54);
  const Similarity still;
  for (double z = 0.03; z > 0.01; z -= kStep) thing.lead({-0.05, 0.0, z});
  thing.go_to(still);
  for (int tick = 0; tick < 5; ++tick) thing.stay();
  Vector3d last = thing.stay().proxy.position;
  double farthest = 0.0;
  for (double x = -0.05; x < 0.05; x += kStep) {
    const Vector3d now = thing.lead({x, 0.0, 0.01}).proxy.position;
    farthest = std::max(farthest, (now - last).norm());
    last = now;
  }
  EXPECT_GT(farthest, 1.2 * kStep) << "it has to go up the step";
  EXPECT_LE(farthest, kStep + kLittle + 1e-6);
}

TEST(ProxyInAMovingScene, TakesNothingFromTheHeap) {
  MovingThing thing("sphere", 53);
  thing.input.tool.position = {0.0, 0.0, 0.15 + kRadius + 0.005};
  const test::AllocationGuard guard;
  for (int k = 0; k < 40; ++k) thing.go_to(moved({0.0, 0.0, 5e-4 * k}));
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(thing.felt().wrench.force.z(), 1.0);
}

}  // namespace
}  // namespace palpate

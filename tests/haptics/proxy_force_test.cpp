// The proxy against surfaces that are known exactly. What a force model promises is measured by `palpate
// evaluate`; here is what must never break.

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/geometry/rotation.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/haptics/tool_file.h>
#include <palpate/study/procedural.h>
#include <palpate/study/seen_surface.h>
#include <support/allocation_guard.h>
#include <support/ball_on_surface.h>
#include <support/example_tools.h>
#include <support/smooth_places.h>
#include <support/splats.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::AllocationGuard;
using test::everywhere;
using test::kRadius;
using test::kStiffness;
using test::noisy;

/// Without noise.
ProceduralOptions even(double spacing) {
  ProceduralOptions options;
  options.spacing = spacing;
  return options;
}

/// A surface, its Gaussians, and a tool that feels them: a ball, if none is said.
class Bench {
 public:
  Bench(const std::string& shape, const ProceduralOptions& options, ProxyParameters parameters = {},
        const Tool& tool = Tool{Vector3d::Constant(kRadius)})
      : surface(make_surface(shape)),
        seen(make_scene(*surface, options), Similarity{}),
        index_(make_scene(*surface, options), SceneFilter{}, Similarity{}) {
    parameters.stiffness = kStiffness;
    model = std::make_unique<ProxyForce>(index_, tool, parameters);
  }

  ForceOutput at(const Vector3d& position) {
    ForceInput input;
    input.tool.position = position;
    input.dt = 1e-3;
    input.contacts = &none_;
    return model->evaluate(input);
  }

  /// Whether the ball touches an ellipsoid there.
  bool touches(const Vector3d& position) {
    index_.query({position, kRadius * Eigen::Matrix3d::Identity()}, touched_);
    return !touched_.contacts.empty();
  }

  std::unique_ptr<AnalyticSurface> surface;
  SeenSurface seen;
  std::unique_ptr<ProxyForce> model;

 private:
  SceneIndex index_;
  ContactSet none_, touched_;
};

double degrees_between(const Vector3d& a, const Vector3d& b) {
  return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0)) * 180.0 / std::numbers::pi;
}

double quantile(std::vector<double> values, double p) {
  std::sort(values.begin(), values.end());
  return values.at(
      std::min(values.size() - 1, static_cast<std::size_t>(p * static_cast<double>(values.size()))));
}

class OnShapes : public testing::TestWithParam<const char*> {};

/// The force of a spring to the nearest place before a plane alone.
Vector3d force_of(const LocalSurface& local, std::size_t k, const Vector3d& at) {
  const ContactPlane& plane = local.planes[k];
  return local.stiffness * std::max(0.0, plane.normal.dot(plane.point - at)) * plane.normal;
}

// A ball that a single plane holds: what the client renders is what the model shows.
TEST(TheLocalSurface, HasTheForceOfTheModelInIt) {
  Bench bench("sphere", even(0.004));
  const double touches =
      *bench.seen.first_touch(Tool(Vector3d::Constant(kRadius)), Vector3d(0, 0, 0.3), Vector3d(0, 0, -1));
  const double height = 0.3 - touches;
  for (double depth = -0.02; depth < 0.01; depth += 1e-4) {
    const Vector3d place(0, 0, height - depth);
    const ForceOutput felt = bench.at(place);
    ASSERT_NEAR(felt.local.planes[0].normal.norm(), 1.0, 1e-9);
    if (depth < -0.01) {
      EXPECT_EQ(felt.local.count, 0U) << "far from everything";
      EXPECT_EQ(felt.local.stiffness, kStiffness);
    }
    if (depth < 0.002) continue;
    ASSERT_GE(felt.local.count, 1U);
    EXPECT_LT((force_of(felt.local, 0, place) - felt.wrench.force).norm(), 0.02 * felt.wrench.force.norm());
  }
}

// On a floor beside a wall that has been touched: how far away that is, the plane says.
TEST(TheLocalSurface, HasAPlaneThatIsNear) {
  constexpr double kWall = 0.03, kDepth = 0.003;
  std::vector<test::Splat> splats;
  const Eigen::Quaterniond upright(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitY()));
  for (int i = -20; i <= 20; ++i)
    for (int k = -20; k <= 20; ++k) {
      const double a = 0.003 * i, b = 0.003 * k;
      const Vector3d semi_axes(0.002, 0.002, 1e-4);
      splats.push_back(test::splat({a, b, 0.0}, semi_axes, Eigen::Quaterniond::Identity(), 0.95));
      splats.push_back(test::splat({kWall, b, a}, semi_axes, upright, 0.95));
    }
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kStiffness});
  ForceInput input;
  input.dt = 1e-3;
  const double touches = kWall - kRadius;
  for (double z = 0.03; z > kRadius - kDepth; z -= 1e-4) {
    input.tool.position = {touches - 0.02, 0.0, z};
    model.evaluate(input);
  }
  ForceOutput felt;
  const auto slide_to = [&](double x) {
    while (std::abs(x - input.tool.position.x()) > 1e-9) {
      input.tool.position.x() += std::clamp(x - input.tool.position.x(), -1e-4, 1e-4);
      felt = model.evaluate(input);
    }
  };
  slide_to(touches + kDepth);
  ASSERT_EQ(felt.local.count, 2U);
  EXPECT_NEAR(felt.wrench.force.x(), -kStiffness * kDepth, 0.1 * kStiffness * kDepth);
  for (const double away : {0.0005, 0.001, 0.0015}) {
    slide_to(touches - away);
    ASSERT_EQ(felt.local.count, 2U);
    const ContactPlane &floor = felt.local.planes[0], &wall = felt.local.planes[1];
    EXPECT_GT(floor.normal.z(), 0.99);
    EXPECT_LT(wall.normal.x(), -0.99);
    const Vector3d proxy = felt.proxy.position;
    EXPECT_NEAR(floor.normal.dot(proxy - floor.point), 0.0, 1e-4);
    EXPECT_NEAR(wall.normal.dot(proxy - wall.point), away, 2e-4);
  }
}

TEST_P(OnShapes, PushesAlongTheNormalAsASpringDoesHoweverDeep) {
  Bench bench(GetParam(), noisy(921));
  std::vector<double> angles, ratios;
  for (const SurfaceSample& s : test::smooth_places(*bench.surface, GetParam(), 40, 922)) {
    bench.model->reset();
    // How deep it is in the true surface when it meets the noisy one that is seen.
    const double seen = *bench.seen.first_touch(Tool(Vector3d::Constant(kRadius)),
                                                s.point + 2.0 * kRadius * s.normal, -s.normal) -
                        kRadius;
    for (double depth = -0.012; depth < 0.030; depth += 1e-4) {
      const Wrench wrench = bench.at(s.point + (kRadius - depth) * s.normal).wrench;
      if (depth < 0.004) continue;
      ASSERT_GT(wrench.force.norm(), 0.0) << "silent at " << depth;
      angles.push_back(degrees_between(wrench.force, s.normal));
      ratios.push_back(wrench.force.norm() / (kStiffness * (depth - seen)));
      EXPECT_LE(wrench.torque.norm(), 1e-3 * kRadius * wrench.force.norm());  // a ball has no lever
    }
  }
  EXPECT_LE(quantile(angles, 0.5), 2.5);
  EXPECT_LE(quantile(angles, 0.95), 6.0);
  EXPECT_LE(quantile(angles, 1.0), 20.0) << "nothing flips";
  EXPECT_NEAR(quantile(ratios, 0.5), 1.0, 0.03);
}

TEST_P(OnShapes, SlidesWithoutJumps) {
  Bench bench(GetParam(), noisy(923));
  constexpr double kStep = 1e-4, kDepth = 0.01;  // 0.1 m/s at 1 kHz
  for (SurfaceSample s : test::smooth_places(*bench.surface, GetParam(), 10, 924)) {
    bench.model->reset();
    for (double depth = -0.005; depth < kDepth; depth += kStep)
      bench.at(s.point + (kRadius - depth) * s.normal);
    Vector3d last = bench.at(s.point + (kRadius - kDepth) * s.normal).wrench.force;
    for (int tick = 0; tick < 200; ++tick) {
      const NearestPoint next = bench.surface->project(s.point + kStep * s.tangent + 1e-3 * s.normal);
      s.point = next.point;
      s.normal = next.normal;
      s.tangent = (s.tangent - s.normal.dot(s.tangent) * s.normal).normalized();
      const Vector3d force = bench.at(s.point + (kRadius - kDepth) * s.normal).wrench.force;
      ASSERT_LE((force - last).norm(), 0.15 + kStiffness * kStep);
      last = force;
    }
  }
}

TEST_P(OnShapes, IsNeverPulledThrough) {
  Bench bench(GetParam(), noisy(925));
  Random random(926);
  int pushes = 0;
  for (const SurfaceSample& s : test::smooth_places(*bench.surface, GetParam(), 40, 927)) {
    bench.model->reset();
    const bool fast = pushes++ % 4 == 0;  // 2 m/s at 1 kHz
    const double step = fast ? 2e-3 : random.uniform(1e-4, 1e-3);
    const Vector3d aside{random.normal(), random.normal(), random.normal()};
    const Vector3d along = (-s.normal + 0.4 * aside.normalized()).normalized();
    const Vector3d start = s.point - 0.04 * along;
    for (double way = 0.0; way < 0.04 + 3.0 * kRadius; way += step) {
      const Vector3d proxy = bench.at(start + way * along).proxy.position;
      // The ball's centre keeps its radius from the surface, but for what is smoothed.
      ASSERT_GE(bench.surface->distance(proxy), 0.75 * kRadius);
      if (bench.surface->closed()) continue;
      const NearestPoint nearest = bench.surface->project(proxy);
      if ((nearest.point - s.point).norm() > 0.05) continue;  // a sheet ends somewhere
      ASSERT_GT((proxy - nearest.point).dot(s.normal), 0.0) << "on the other side";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Proxy, OnShapes, testing::Values("sphere", "cylinder", "torus", "plane", "shell"));

// 64 a squared detail of pi a b: 64 pi 0.1 0.03 / 0.02^2 = 1507.96.
TEST(EnoughForAView, IsByTheLargestCrossSection) {
  EXPECT_EQ(enough_for({"", Vector3d(0.03, 0.1, 0.03)}, 0.02), 1507U);
  EXPECT_EQ(enough_for({"", Vector3d(0.01, 0.03, 0.1)}, 0.02), 1507U);
  EXPECT_EQ(enough_for({"", Vector3d::Constant(0.04)}, 0.01), 3216U);
  EXPECT_EQ(enough_for({"", Vector3d::Constant(0.04)}, 0.1), CandidateCache::kLeastCapacity);
  EXPECT_EQ(enough_for({"", Vector3d::Constant(0.04)}, 1e-9), CandidateCache::kCapacity);
}

// It is free, but knows the sheet that it has touched, and nothing is new to be seen on its way.
TEST(ProxyForce, AFreeToolDoesNotPassASheetThatItHasTouched) {
  const auto surface = make_surface("plane");
  const SceneIndex index(make_scene(*surface, ProceduralOptions{}), SceneFilter{}, Similarity{});
  ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kStiffness});
  ForceInput input;
  input.dt = 1e-3;
  const auto go_to = [&](double above) {
    input.tool.position = {0.003, 0.002, kRadius + above};
    return model.evaluate(input);
  };
  for (int k = 30; k > -10; --k) go_to(1e-4 * k);
  for (int k = -10; k < 10; ++k) go_to(1e-4 * k);
  for (int k = 0; k < 20; ++k) ASSERT_EQ(go_to(1e-3).wrench.force, Vector3d(0, 0, 0)) << k;
  const double deep = 3.0 * kRadius;  // beyond it, where it touches nothing
  ForceOutput felt = go_to(-deep);
  for (int k = 0; k < 20; ++k) felt = go_to(-deep);
  EXPECT_NEAR(felt.proxy.position.z(), kRadius, 0.001);
  EXPECT_NEAR(felt.wrench.force.z(), kStiffness * deep, 0.02 * kStiffness * deep);
}

// What a patch looks at is looked up, wherever the tool touches: at the tip of a rod, too.
TEST(EnlargedPart, HoldsTheWindowThatATipTouchesWith) {
  constexpr double kDetail = 0.004, kReach = 0.001, kFar = 0.02;
  for (const Vector3d& axes : {Vector3d(0.1, 0.003, 0.003), Vector3d(0.1, 0.1, 0.01),
                               Vector3d(0.05, 0.02, 0.006), Vector3d(0.02, 0.02, 0.02)}) {
    const ToolPart part{"", axes};
    const Vector3d larger = enlarged(part, kDetail, kReach).semi_axes;
    const double w = 0.88 * SurfacePatches::kWindow * kDetail;
    for (Eigen::Index tip = 0; tip < 3; ++tip) {
      for (Eigen::Index aside = 0; aside < 3; ++aside) {
        if (aside == tip) continue;
        const Vector3d point = axes[tip] * Vector3d::Unit(tip) + w * Vector3d::Unit(aside);
        EXPECT_LE(point.cwiseQuotient(larger).norm(), 1.0 + 1e-9) << axes.transpose();
      }
    }
    EXPECT_TRUE((larger.array() >= axes.array() + kReach).all());
    EXPECT_TRUE((enlarged(part, kDetail, kFar).semi_axes.array() >= axes.array() + kFar).all());
    // Of a ball, no more than that.
    if (axes[0] == axes[2]) {
      EXPECT_NEAR(larger[0], std::hypot(axes[0], w), 1e-12);
    }
  }
}

// Of semi-axes sqrt(p a^2 + q), which are searched here more finely: sixteen times as many p, and for each
// the least q by bisection.
TEST(EnlargedPart, IsNoLargerThanItMustBe) {
  constexpr double kDetail = 0.004;
  const double w2 = std::pow(0.88 * SurfacePatches::kWindow * kDetail, 2);
  for (const Vector3d& axes : {Vector3d(0.1, 0.003, 0.003), Vector3d(0.1, 0.1, 0.01),
                               Vector3d(0.05, 0.02, 0.006), Vector3d(0.02, 0.015, 0.012)}) {
    const Eigen::Array3d squared = axes.array().square();
    const double a = squared.maxCoeff(), b = squared.minCoeff();
    double least = std::numeric_limits<double>::infinity();
    constexpr int kTries = 512;
    for (int k = 1; k <= kTries; ++k) {
      const double p = 1.0 + k * w2 / (kTries * b);
      const auto holds = [&](double q) {
        return p * b + q >= b + w2 && a / (p * a + q) + w2 / (p * b + q) <= 1.0;
      };
      double low = -p * b, high = a + w2;
      ASSERT_TRUE(holds(high));
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (holds(middle) ? high : low) = middle;
      }
      least = std::min(least, (p * squared + high).sqrt().prod());
    }
    const double found = enlarged({"", axes}, kDetail, 0.0).semi_axes.prod();
    EXPECT_GE(found, least * (1.0 - 1e-3)) << axes.transpose();
    EXPECT_LE(found, 1.01 * least) << axes.transpose();
  }
}

TEST(ProxyForce, IsZeroAndFollowsTheToolOutOfContact) {
  Bench bench("plane", noisy(931));
  for (double z = 0.1; z > kRadius + 0.006; z -= 1e-3) {
    const ForceOutput felt = bench.at({0, 0, z});
    EXPECT_EQ(felt.wrench.force, Vector3d(0, 0, 0));
    EXPECT_EQ(felt.confidence, 1.0);
    EXPECT_EQ(felt.stiffness, 0.0);
    EXPECT_NEAR((felt.proxy.position - Vector3d(0, 0, z)).norm(), 0.0, 1e-12);
  }
}

// Led along noise, up and down about where it touches, so that contacts end and begin where
// patches of others are still known.
TEST(ProxyForce, BeginsAContactOnlyWhereTheToolTouches) {
  for (const std::string shape : {"plane", "sphere"}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      Bench bench(shape, noisy(seed));
      const SurfaceSample s = test::smooth_places(*bench.surface, shape, 1, seed).front();
      const Vector3d along = 1e-5 * s.normal.unitOrthogonal();
      bool contact = false;
      int begun = 0, ended = 0;
      for (int k = 0; k < 6000; ++k) {
        const double height = kRadius + 0.005 * std::cos(2.0 * std::numbers::pi * k / 300.0);
        const Vector3d way = s.point + k * along;
        const Vector3d at = way + height * bench.surface->project(way).normal;
        const ForceOutput output = bench.at(at);
        const bool felt = !output.wrench.force.isZero(0.0), touches = bench.touches(at), was = contact;
        // A proxy that is still on its way back may pull with nothing for a tick.
        contact = touches || (contact && output.proxy.position != at);
        ASSERT_TRUE(contact || !felt) << shape << ", seed " << seed << ", tick " << k;
        ASSERT_TRUE(felt || output.confidence == 1.0) << shape << ", seed " << seed << ", tick " << k;
        begun += contact && !was ? 1 : 0;
        ended += was && !contact ? 1 : 0;
      }
      EXPECT_GE(begun, 10) << shape << ", seed " << seed;
      EXPECT_GE(ended, 10) << shape << ", seed " << seed;
    }
  }
}

TEST(ProxyForce, HasTheFrictionThatIsSet) {
  for (const double friction : {0.1, 0.3, 0.6}) {
    ProxyParameters parameters;
    parameters.friction = friction;
    Bench bench("plane", even(0.006), parameters);
    Vector3d at(-0.1, 0.03, kRadius);
    for (; at.z() > kRadius - 0.008; at.z() -= 1e-4) bench.at(at);
    std::vector<double> measured;
    for (; at.x() < 0.1; at.x() += 1e-4) {
      const Vector3d force = bench.at(at).wrench.force;
      if (at.x() > -0.05) measured.push_back(-force.x() / force.z());
    }
    EXPECT_NEAR(quantile(measured, 0.5), friction, 0.05 * friction);
  }
}

TEST(ProxyForce, HasTheFrictionThatIsSetForATool) {
  // One that is longer than wide and stands aslant: what it touches is beside its centre.
  ProceduralOptions even;
  even.spacing = 0.004;
  const auto surface = make_surface("plane");
  const SceneIndex index(make_scene(*surface, even), SceneFilter{}, Similarity{});
  for (const double friction : {0.1, 0.2, 0.4}) {
    ProxyForce model(index, Tool({0.02, 0.02, 0.04}), {.stiffness = kStiffness, .friction = friction});
    ForceInput input;
    input.dt = 1e-3;
    input.tool.orientation = Eigen::AngleAxisd(0.3, Vector3d::UnitX()) * Eigen::Quaterniond::Identity();
    input.tool.position = {-0.1, 0.03, 0.05};
    for (; input.tool.position.z() > 0.030; input.tool.position.z() -= 1e-4) model.evaluate(input);
    std::vector<double> measured;
    for (; input.tool.position.x() < 0.1; input.tool.position.x() += 1e-4) {
      const Vector3d force = model.evaluate(input).wrench.force;
      if (input.tool.position.x() > -0.05) measured.push_back(-force.x() / force.z());
    }
    EXPECT_NEAR(quantile(measured, 0.5), friction, 0.05 * friction);
  }
}

/// Everything `scale` times as large, felt by a hand whose centimetre is so many of the scene: force over
/// scale is what a WorkspaceMap makes of it.
std::vector<Vector3d> felt_by_hand(double scale) {
  const Similarity larger{scale, Eigen::Quaterniond::Identity(), Vector3d::Zero()};
  const SceneIndex index(make_scene(*make_surface("sphere"), noisy(941)), SceneFilter{}, larger);
  ProxyParameters parameters;
  parameters.hand_scale = scale;
  ProxyForce model(index, Tool{Vector3d::Constant(scale * kRadius)}, parameters);
  std::vector<Vector3d> felt;
  ForceInput input;
  input.dt = 1e-3;
  for (int tick = 0; tick < 600; ++tick) {
    const double in = std::min(tick, 250) * 1e-4, along = std::max(0, tick - 250) * 1e-4;
    input.tool.position = scale * Vector3d(along, 0.0, 0.15 + kRadius + 0.01 - in);
    felt.push_back(model.evaluate(input).wrench.force / scale);
  }
  return felt;
}

TEST(ProxyForce, FeelsAlikeAtEveryScaleOfTheHand) {
  const std::vector<Vector3d> one = felt_by_hand(1.0);
  EXPECT_GT(one.back().norm(), 1.0);
  for (const double scale : {0.0625, 0.25, 16.0}) {  // powers of two: all that differs is rounding
    const std::vector<Vector3d> other = felt_by_hand(scale);
    double worst = 0.0;
    for (std::size_t i = 0; i < one.size(); ++i) worst = std::max(worst, (other[i] - one[i]).norm());
    EXPECT_LE(worst, 0.01 * one.back().norm()) << scale;
  }
}

// What a proxy may put into the spring by itself goes by the hand's energy: force times way, both to scale.
TEST(ProxyForce, BeginsWithNoMoreEnergyThanTheHandMayBeGiven) {
  for (const double scale : {0.05, 1.0, 50.0}) {
    ProxyParameters parameters;
    parameters.hand_scale = scale;
    Bench bench("plane", even(0.006), parameters);
    for (int k = 0; k < 2; ++k) {
      EXPECT_LE(bench.at({0, 0, 0.1}).stored_energy, ProxyForce::kReserve * scale * scale * (1.0 + 1e-12))
          << scale;
      bench.model->reset();
    }
  }
}

// Captures have Gaussians as large as a city, and as thin as rounding.
TEST(ProxyForce, IsFiniteAmongGiantsAndNeedles) {
  std::vector<test::Splat> splats;
  Random random(942);
  for (const double size : {1e-12, 1e-6, 1e-2, 1e3, 1e9, 1e12})
    for (int i = 0; i < 30; ++i) {
      const Vector3d at = 0.05 * Vector3d{random.normal(), random.normal(), random.normal()};
      splats.push_back(
          test::splat(at, {size, size * random.uniform(1e-9, 1.0), i % 3 == 0 ? 0.0 : 1e-9 * size}));
    }
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  ProxyForce model(index, Tool{Vector3d(0.02, 0.02, 0.04)});
  ForceInput input;
  input.dt = 1e-3;
  for (int tick = 0; tick < 2000; ++tick) {
    input.tool.position =
        0.1 * Vector3d(std::cos(0.01 * tick), std::sin(0.013 * tick), std::sin(0.007 * tick));
    const ForceOutput felt = model.evaluate(input);
    ASSERT_TRUE(felt.wrench.force.allFinite() && felt.wrench.torque.allFinite()) << tick;
    ASSERT_TRUE(felt.proxy.position.allFinite()) << tick;
  }
}

TEST(ProxyForce, SticksWithoutCreeping) {
  ProxyParameters parameters;
  parameters.friction = 0.5;
  Bench bench("sphere", noisy(932), parameters);
  const double reach = 0.15 + kRadius;
  for (double z = reach + 0.005; z > reach - 0.008; z -= 1e-4) bench.at({0, 0, z});
  const Vector3d aside(0.002, 0.0, reach - 0.008);  // within the cone
  ForceOutput felt;
  for (int tick = 0; tick < 200; ++tick) felt = bench.at(aside);
  const Vector3d before = felt.proxy.position;
  // Of the 2 mm the ball rolls a part on the point that sticks: with g^2 = 9 * 2/5 R^2, 1 / 4.6 on a plane.
  EXPECT_NEAR(-felt.wrench.force.x(), kStiffness * 0.002 * 3.6 / 4.6, 0.25 * kStiffness * 0.002);
  for (int tick = 0; tick < 10000; ++tick) felt = bench.at(aside);
  EXPECT_LE((felt.proxy.position - before).norm(), 1e-6);
}

TEST(ProxyForce, StaysOutOfACorner) {
  // Two walls and a floor, each a sheet of splats.
  std::vector<test::Splat> splats;
  const auto sheet = [&](const Vector3d& u, const Vector3d& v) {
    const Eigen::Quaterniond q = rotation_between(Vector3d::UnitZ(), u.cross(v));
    for (int i = 0; i < 30; ++i)
      for (int k = 0; k < 30; ++k)
        splats.push_back(test::splat(0.005 * (i * u + k * v), {0.003, 0.003, 0.0005}, q));
  };
  sheet(Vector3d::UnitX(), Vector3d::UnitY());
  sheet(Vector3d::UnitY(), Vector3d::UnitZ());
  sheet(Vector3d::UnitZ(), Vector3d::UnitX());
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  ProxyForce model(index, Tool{Vector3d::Constant(kRadius)}, {.stiffness = kStiffness});
  ContactSet none;
  ForceInput input;
  input.contacts = &none;
  ForceOutput felt;
  for (double x = 0.08; x > 0.0; x -= 2e-4) {
    input.tool.position.setConstant(x);
    felt = model.evaluate(input);
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(felt.proxy.position[axis], kRadius, 0.15 * kRadius);
    EXPECT_GT(felt.wrench.force[axis], 0.8 * kStiffness * kRadius);
  }
}

// Far below a floor, where the tool itself touches nothing: what stands on the floor stops the proxy.
TEST(ProxyForce, IsStoppedByAWallThatTheToolDoesNotTouch) {
  std::vector<test::Splat> splats;
  const Eigen::Quaterniond upright = rotation_between(Vector3d::UnitZ(), Vector3d::UnitX());
  for (int i = -20; i <= 20; ++i)
    for (int k = -10; k <= 10; ++k) {
      splats.push_back(test::splat({0.005 * i, 0.005 * k, 0.0}, {0.004, 0.004, 0.0002}));
      if (i >= 0)
        splats.push_back(test::splat({0.05, 0.005 * k, 0.005 * i}, {0.004, 0.004, 0.0002}, upright));
    }
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  ProxyForce model(index, Tool{Vector3d::Constant(kRadius)}, {.stiffness = kStiffness, .friction = 0.3});
  ForceInput input;
  input.dt = 1e-3;
  ForceOutput felt;
  for (double z = 0.04; z > -0.06; z -= 1e-4) {
    input.tool.position = {-0.03, 0.001, z};
    felt = model.evaluate(input);
  }
  EXPECT_NEAR(felt.proxy.position.z(), kRadius, 0.05 * kRadius);
  for (; input.tool.position.x() < 0.09; input.tool.position.x() += 1e-4) {
    felt = model.evaluate(input);
    ASSERT_LT(felt.proxy.position.x(), 0.05 - 0.75 * kRadius) << input.tool.position.x();
  }
  EXPECT_NEAR(felt.wrench.force.x(), -kStiffness * (0.04 + kRadius), 0.1 * kStiffness * 0.06);
}

// A lone needle aslant, whose tip is 17 mm nearer to the ball than its middle.
TEST(ProxyForce, MeetsTheTipOfALoneNeedle) {
  const Vector3d along = Vector3d(-0.5, 0.1, 0.85).normalized(), middle(0.012, 0, -0.03);
  const SceneIndex index(test::scene_of({test::splat(middle, {0.02, 2e-4, 2e-4},
                                                     rotation_between(Vector3d::UnitX(), along), 0.95)}),
                         SceneFilter{}, Similarity{});
  ProxyForce model(index, Tool{Vector3d::Constant(kRadius)}, {.stiffness = kStiffness});
  ForceInput input;
  input.dt = 1e-3;
  input.tool.position = {0.001, 0.002, 0.03};
  while (model.evaluate(input).wrench.force.isZero(0.0) && input.tool.position.z() > -0.05)
    input.tool.position.z() -= 1e-4;
  const Vector3d tip = middle + 0.02 * along;
  const double aside = (tip - input.tool.position).head<2>().squaredNorm();
  const double meets = tip.z() + std::sqrt(kRadius * kRadius - aside);
  EXPECT_NEAR(input.tool.position.z(), meets, 0.1 * kRadius);
}

TEST(ProxyForce, StandsOnTheEndOfALongTool) {
  const auto surface = make_surface("plane");
  const SceneIndex index(make_scene(*surface, {}), SceneFilter{}, Similarity{});
  ProxyForce model(index, Tool{}, {.stiffness = kStiffness, .friction = 0.3});
  ForceInput input;
  input.dt = 1e-3;
  input.tool.position = {0, 0, 0.05};
  ForceOutput felt;
  for (; input.tool.position.z() > 0.01; input.tool.position.z() -= 1e-4) felt = model.evaluate(input);
  EXPECT_NEAR(felt.wrench.force.z(), 0.03 * kStiffness, 0.07 * 0.03 * kStiffness);
  for (; input.tool.position.x() < 0.05; input.tool.position.x() += 1e-4) felt = model.evaluate(input);
  EXPECT_NEAR(-felt.wrench.force.x() / felt.wrench.force.z(), 0.3, 0.05 * 0.3);
}

TEST(ProxyForce, TurnsALongToolAlongAWall) {
  const auto surface = make_surface("plane");
  const SceneIndex index(make_scene(*surface, {}), SceneFilter{}, Similarity{});
  ProxyForce model(index, Tool({0.02, 0.02, 0.04}), {.stiffness = kStiffness});
  ContactSet none;
  ForceInput input;
  input.contacts = &none;
  // Its long axis 30 degrees above the plane, along x: the lower end touches first.
  const Vector3d y = Vector3d::UnitY();
  input.tool.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(2.0 * std::numbers::pi / 3.0, y));
  ForceOutput felt;
  for (double z = 0.05; z > 0.015; z -= 1e-4) {
    input.tool.position = {0, 0, z};
    felt = model.evaluate(input);
  }
  EXPECT_GT(felt.wrench.force.z(), 5.0);
  // The long axis, (sin 120, 0, cos 120), points down at +x: what pushes up there turns about -y.
  EXPECT_LT(felt.wrench.torque.y(), -0.01);
  EXPECT_NEAR(felt.wrench.torque.x(), 0.0, 0.1 * std::abs(felt.wrench.torque.y()));
}

/// The bench's tool pressed straight down at (x, y), to where its handle is at height `z`.
ForceOutput press(Bench& bench, double x, double y, double z) {
  ForceOutput felt;
  const double start = z + 0.02;
  constexpr int kTicks = 200;
  for (int tick = 0; tick <= kTicks; ++tick) felt = bench.at({x, y, start + (z - start) * tick / kTicks});
  return felt;
}

/// How far a part is below z = 0; negative above.
double below_the_plane(const ToolPart& part, const Pose& tool) {
  const Ellipsoid solid = part.at(tool);
  return solid.support(Vector3d::UnitZ()) - solid.center.z();
}

// Its centre does not move at all, and its ends go opposite ways: up to some 30 mm a tick, of which a look
// sees a few.
TEST(ProxyForce, ATurnAloneMeetsASurface) {
  const Tool rod({0.1, 0.005, 0.005});
  for (const double sense : {1.0, -1.0}) {
    for (const double turn : {2e-3, 0.02, 0.33}) {
      Bench bench("plane", even(0.004), {}, rod);
      ForceInput input;
      input.dt = 1e-3;
      input.tool.position = {0, 0, 0.03};
      ForceOutput felt;
      for (double angle = 0.0; angle < 1.0; angle += turn) {
        input.tool.orientation = Eigen::AngleAxisd(sense * angle, Vector3d::UnitY());
        felt = bench.model->evaluate(input);
        ASSERT_LT(below_the_plane(rod.parts()[0], felt.proxy), 0.0005) << angle << " by " << turn;
      }
      EXPECT_GT(below_the_plane(rod.parts()[0], input.tool), 0.05);
      EXPECT_GT(felt.wrench.force.z(), 1.0);
      EXPECT_LT(sense * felt.wrench.torque.y(), -0.05) << "it is turned back";
    }
  }
}

// More parts on more splats than a tick may look at: the proxy waits for what it has not seen, and gets
// there. All meet the plane at once, which takes four looks of each, some ticks: what it comes late by is not
// from the hand, and not felt.
TEST(ProxyForce, HoldsAToolOfManyPartsOnADenseScene) {
  constexpr double kSmall = 0.008;
  std::vector<ToolPart> balls;
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 6; ++k)
      balls.push_back(
          {"ball", Vector3d::Constant(kSmall), {{0.016 * (i - 3.5), 0.016 * (k - 2.5), 0.0}, {}}});
  for (ToolPart& ball : balls) ball.pose.orientation.setIdentity();
  const Tool tool(balls);
  Bench bench("plane", even(0.0015), {}, tool);
  constexpr double kDepth = 0.006;
  const ForceOutput felt = press(bench, 0.0, 0.0, kSmall - kDepth);
  for (const ToolPart& part : tool.parts()) EXPECT_LT(below_the_plane(part, felt.proxy), 0.001);
  constexpr double kLate = 15 * 0.02 / 200;  // so many ticks of press()
  EXPECT_GT(felt.wrench.force.z(), kStiffness * (kDepth - kLate));
  EXPECT_LT(felt.wrench.force.z(), 1.01 * kStiffness * kDepth);
}

// A sample stands for the Gaussians near a tool where they are more than there is room for.
TEST(ProxyForce, HoldsAToolThatIsLargeForTheSceneAsOneThatIsNot) {
  constexpr double kLarge = 0.1;
  const Tool tool(Vector3d::Constant(kLarge));
  Bench dense("plane", even(0.0016), {}, tool), sparse("plane", even(0.01), {}, tool);
  for (Bench* bench : {&dense, &sparse}) {
    for (double z = kLarge + 0.02; z > kLarge - 0.03; z -= 2e-4) bench->at({0.003, -0.002, z});
    const double force = bench->at({0.003, -0.002, kLarge - 0.03}).wrench.force.z();
    EXPECT_NEAR(force, kStiffness * 0.03, 0.05 * kStiffness * 0.03);
  }
}

// Where nothing is touched on the way there is nothing to look at, however far a tick takes it.
TEST(ProxyForce, KeepsUpWithAFastToolInFreeSpace) {
  for (const Vector3d& semi_axes :
       {Vector3d(0.1, 0.003, 0.003), Vector3d(0.1, 0.1, 0.01), Vector3d(0.02, 0.02, 0.02)}) {
    Bench bench("plane", even(0.0015), {}, Tool(semi_axes));
    ForceInput input;
    input.dt = 1e-3;
    for (int tick = 0; tick < 40; ++tick) {
      input.tool.position = {0.05 * std::abs(tick - 20), 0.0, 0.12};  // at 50 m/s, and back
      input.tool.orientation = Eigen::AngleAxisd(0.1 * tick, Vector3d::UnitY());
      const ForceOutput felt = bench.model->evaluate(input);
      EXPECT_EQ(felt.proxy.position, input.tool.position) << semi_axes.transpose() << " at " << tick;
      EXPECT_EQ(felt.wrench.force.norm(), 0.0);
    }
  }
}

// One that goes through the plane at that speed is stopped there, wherever it was in the tick before.
TEST(ProxyForce, StopsAFastToolThatComesOutOfFreeSpace) {
  for (const Vector3d& semi_axes :
       {Vector3d(0.003, 0.003, 0.1), Vector3d(0.1, 0.003, 0.003), Vector3d(0.02, 0.02, 0.02)}) {
    const double low = semi_axes.z();
    for (double start = low + 0.001; start < low + 0.06; start += 0.0071) {
      Bench bench("plane", even(0.004), {}, Tool(semi_axes));
      for (int tick = -4; tick < 4; ++tick) {
        const ForceOutput felt = bench.at({0.0011, 0.0007, start - 0.06 * tick});
        ASSERT_GT(felt.proxy.position.z(), low - 2e-4) << semi_axes.transpose() << " from " << start;
      }
      const ForceOutput felt = bench.at({0.0011, 0.0007, start - 0.06 * 3});
      EXPECT_LT(felt.proxy.position.z(), low + 1e-3) << semi_axes.transpose() << " from " << start;
      EXPECT_GT(felt.wrench.force.z(), 10.0);
    }
  }
}

// Thousands of contacts at once: the deepest are looked at, and it comes out of them in some ticks.
TEST(ProxyForce, ComesOutOfACrowdThatItStartsIn) {
  constexpr double kLarge = 0.1, kDepth = 0.03;
  Bench bench("plane", even(0.0016), {}, Tool(Vector3d::Constant(kLarge)));
  ForceOutput felt;
  for (int tick = 0; tick < 20; ++tick) felt = bench.at({0.003, -0.002, kLarge - kDepth});
  EXPECT_NEAR(felt.proxy.position.z(), kLarge, 0.05 * kDepth);
  EXPECT_NEAR(felt.wrench.force.z(), kStiffness * kDepth, 0.05 * kStiffness * kDepth);
}

// More contacts than are looked at, all shallow but for a few, wherever those are in the index.
TEST(ProxyForce, ComesOutOfTheDeepestThatItStartsIn) {
  constexpr double kLarge = 0.1, kShallow = 0.005, kDeep = 0.03;
  const Vector3d center(0, 0, kLarge - kShallow);
  for (const double side : {1.0, -1.0}) {
    std::vector<test::Splat> splats;
    for (int i = -30; i <= 30; ++i)
      for (int k = -30; k <= 30; ++k)
        splats.push_back(test::splat({0.0012 * i, 0.0012 * k, 0.0}, {0.001, 0.001, 1e-5}));
    const Vector3d post = center + (kLarge - kDeep) * Vector3d(side * std::sin(1.0), 0, -std::cos(1.0));
    for (int k = 0; k < 5; ++k) splats.push_back(test::splat(post, {0.02, 0.02, 0.002}));
    const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
    ProxyForce model(index, Tool(Vector3d::Constant(kLarge)), {.stiffness = kStiffness});
    ForceInput input;
    input.dt = 1e-3;
    input.tool.position = center;
    ForceOutput felt;
    for (int tick = 0; tick < 20; ++tick) felt = model.evaluate(input);
    EXPECT_GT((felt.proxy.position - post).norm(), kLarge - 0.2 * kDeep) << side;
  }
}

// All in one place: no smaller solid has fewer.
TEST(ProxyForce, StartsInAHeap) {
  std::vector<test::Splat> splats(3000, test::splat({0, 0, 0}, {0.004, 0.004, 0.001}));
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kStiffness});
  ForceInput input;
  input.dt = 1e-3;
  input.tool.position = {0.0, 0.0, 0.5 * kRadius};
  ForceOutput felt;
  for (int tick = 0; tick < 50; ++tick) felt = model.evaluate(input);
  EXPECT_GT(felt.wrench.force.z(), 0.2 * kStiffness * kRadius);
}

// The part that touches is looked at as well as those before it, which see much and touch nothing.
TEST(ProxyForce, HoldsTheLastOfManyParts) {
  constexpr double kSmall = 0.008, kLower = 0.006, kDepth = 0.004;
  const Eigen::Quaterniond straight = Eigen::Quaterniond::Identity();
  std::vector<ToolPart> balls;
  for (int i = 0; i < 12; ++i)
    for (int k = 0; k < 10; ++k)
      balls.push_back(
          {"ball", Vector3d::Constant(kSmall), {{0.016 * (i - 5.5), 0.016 * (k - 4.5), kLower}, straight}});
  balls.push_back({"last", Vector3d::Constant(kSmall), {{0, 0, 0}, straight}});
  Bench bench("plane", even(0.0015), {}, Tool(balls));
  ForceOutput felt;
  for (double z = 0.03; z > kSmall - kDepth; z -= 1.3e-3) felt = bench.at({0, 0, z});  // 1.3 m/s
  for (int tick = 0; tick < 50; ++tick) {
    felt = bench.at({0, 0, kSmall - kDepth});
    EXPECT_LT(below_the_plane(balls.back(), felt.proxy), 0.001);
  }
  EXPECT_NEAR(felt.wrench.force.z(), kStiffness * kDepth, 0.1 * kStiffness * kDepth);
}

// The others take half of a tick to find out that they touch nothing.
TEST(ProxyForce, HoldsTheLastOfManyPartsWhereItStarts) {
  constexpr double kSmall = 0.008, kDepth = 0.004;
  const Eigen::Quaterniond straight = Eigen::Quaterniond::Identity();
  std::vector<ToolPart> balls;
  for (int k = 0; k < 255; ++k)
    balls.push_back({"ball", Vector3d::Constant(0.002), {{0.0, 0.0, 0.05 + 0.001 * k}, straight}});
  balls.push_back({"last", Vector3d::Constant(kSmall), {{0, 0, 0}, straight}});
  Bench bench("plane", even(0.004), {}, Tool(balls));
  ForceOutput felt;
  for (int tick = 0; tick < 30; ++tick) felt = bench.at({0, 0, kSmall - kDepth});
  EXPECT_NEAR(felt.wrench.force.z(), kStiffness * kDepth, 0.1 * kStiffness * kDepth);
}

/// As many parts as a tool may have, close together. \param top how high they are. Unit: [m].
Tool plate_of_256(double top) {
  constexpr int kSide = 16;
  std::vector<ToolPart> parts;
  for (int i = 0; i < kSide; ++i)
    for (int k = 0; k < kSide; ++k)
      parts.push_back({"part",
                       {0.006, 0.006, top},
                       {{0.008 * (i - 7.5), 0.008 * (k - 7.5), 0.0}, Eigen::Quaterniond::Identity()}});
  return Tool(parts);
}

// What a tick had no budget for, the next does: the searches and looks of 256 parts, most of which touch, do
// not keep the proxy waiting for long, and what they have looked at is not looked at again.
TEST(ProxyForce, GoesOnWithAsManyPartsAsAToolMayHave) {
  constexpr double kTop = 0.008, kDepth = 0.003;
  constexpr int kLongestWait = 60;
  Bench bench("plane", even(0.004), {}, plate_of_256(kTop));
  Vector3d place(0, 0, 0.03), before(0, 0, 1);
  int waits = 0, longest = 0;
  for (int tick = 0; tick < 600; ++tick) {
    if (place.z() > kTop - kDepth) place.z() -= 2e-4;
    place.x() = 0.02 * std::sin(0.005 * tick);
    const Vector3d proxy = bench.at(place).proxy.position;
    EXPECT_GT(proxy.z(), kTop - 1e-3);
    waits = proxy == before ? waits + 1 : 0;
    longest = std::max(longest, waits);
    before = proxy;
  }
  EXPECT_LT(longest, kLongestWait);
  ForceOutput felt;
  for (int tick = 0; tick < 400; ++tick) felt = bench.at(place);
  EXPECT_NEAR(felt.wrench.force.z(), kStiffness * kDepth, 0.1 * kStiffness * kDepth);
}

// The normals of its contacts lie in the plane.
TEST(ProxyForce, StartsInTheVeryMiddleOfAPlane) {
  const double a = kRadius;
  for (const Vector3d& axes : {Vector3d(a, a, a), Vector3d(a, a, 2 * a), Vector3d(5 * a, a, 0.2 * a)}) {
    for (const double spacing : {0.002, 0.004}) {
      Bench bench("plane", even(spacing), {}, Tool(axes));
      ForceOutput felt;
      for (int tick = 0; tick < 100; ++tick) felt = bench.at({0.001, 0.002, 0.0});
      const double out = kStiffness * axes.z();
      EXPECT_NEAR(std::abs(felt.wrench.force.z()), out, 0.1 * out) << axes.transpose();
      EXPECT_LE(felt.wrench.force.head<2>().norm(), 0.1 * out) << axes.transpose();
    }
  }
}

// A tick is not enough to find out what 256 parts are in: there is no force until all have looked, and then
// all hold the tool.
TEST(ProxyForce, StartsInASurfaceWithAsManyPartsAsAToolMayHave) {
  constexpr double kTop = 0.008, kDepth = 0.003;
  Bench bench("plane", even(0.004), {}, plate_of_256(kTop));
  const Vector3d place(0, 0, kTop - kDepth);
  int ticks = 0;
  ForceOutput felt = bench.at(place);
  for (; felt.wrench.force.norm() == 0.0 && ticks < 200; ++ticks) {
    EXPECT_FALSE(felt.is_known) << ticks;
    felt = bench.at(place);
  }
  EXPECT_GT(ticks, 1);
  EXPECT_LT(ticks, 100);
  EXPECT_TRUE(felt.is_known);
  for (int tick = 0; tick < 100; ++tick) felt = bench.at(place);
  EXPECT_NEAR(felt.wrench.force.z(), kStiffness * kDepth, 0.1 * kStiffness * kDepth);
  EXPECT_LT(felt.wrench.torque.norm(), 0.01 * kStiffness * kDepth);
}

// In the air that is soon known, and remains so while it moves.
TEST(ProxyForce, KnowsThatItTouchesNothing) {
  constexpr double kTop = 0.008;
  constexpr int kSoon = 20;  // ticks
  for (const Tool& tool : {Tool(Vector3d::Constant(0.02)), plate_of_256(kTop)}) {
    Bench bench("plane", even(0.004), {}, tool);
    for (int tick = 0; tick < 150; ++tick) {
      const bool known = bench.at(Vector3d(0, 0, 0.1 - 0.0005 * tick)).is_known;
      EXPECT_TRUE(known || tick < kSoon) << tool.parts().size() << " parts, tick " << tick;
    }
  }
}

// So fine a detail sees no farther than half a millimetre: the proxy does not go farther either.
TEST(ProxyForce, DoesNotEnterWhatItHasNotSeen) {
  std::vector<test::Splat> splats;
  for (int i = -10; i <= 10; ++i)
    for (int k = -10; k <= 10; ++k)
      splats.push_back(test::splat({5e-4 * i, 5e-4 * k, 0.0}, {4e-4, 4e-4, 4e-6}));
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  for (const double detail : {0.001, 0.002, 0.004}) {
    for (const double step : {1e-4, 7e-4, 2e-3}) {
      ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kStiffness, .detail = detail});
      ForceInput input;
      input.dt = 1e-3;
      for (double z = 0.04; z > 0.0; z -= step) {
        input.tool.position = {0.0003, 0.0001, z};
        ASSERT_GT(model.evaluate(input).proxy.position.z(), kRadius - 2e-4) << detail << " " << step;
      }
    }
  }
}

TEST(ProxyForce, ComesOutOfWhatItStartsIn) {
  Bench bench("plane", noisy(933));
  const ForceOutput felt = bench.at({0, 0, 0.5 * kRadius});
  EXPECT_NEAR(felt.proxy.position.z(), kRadius, 0.15 * kRadius);
  EXPECT_GT(felt.wrench.force.z(), 0.0);
}

TEST(ProxyForce, FeelsTheSameForAsLongAsItRests) {
  Bench bench("plane", noisy(939));
  for (const SurfaceSample& s : test::smooth_places(*bench.surface, "plane", 10, 940)) {
    bench.model->reset();
    const Vector3d at = s.point + 0.5 * kRadius * s.normal;
    for (int tick = 0; tick < 5; ++tick) bench.at(at);  // it comes out
    const Vector3d first = bench.at(at).wrench.force;
    EXPECT_GT(first.norm(), 0.3 * kStiffness * kRadius);
    Vector3d force = first;
    for (int tick = 0; tick < 200; ++tick) force = bench.at(at).wrench.force;
    EXPECT_NEAR((force - first).norm(), 0.0, 0.02 * first.norm());
  }
}

TEST(ProxyForce, ForgetsAllWhenReset) {
  Bench bench("plane", noisy(934));
  for (double z = 0.05; z > -0.03; z -= 1e-3) bench.at({0, 0, z});
  EXPECT_GT(bench.at({0, 0, -0.03}).proxy.position.z(), 0.0);
  bench.model->reset();
  EXPECT_EQ(bench.at({0.3, 0.3, 0.3}).wrench.force, Vector3d(0, 0, 0));
  Bench other("plane", noisy(934));
  bench.model->reset();
  EXPECT_EQ(bench.at({0, 0, 0.015}).wrench.force, other.at({0, 0, 0.015}).wrench.force);
}

// What it has looked past while a patch was there for it may be anything after a reset, right there.
TEST(ProxyForce, ForgetsWhereItHasLookedWhenReset) {
  Bench bench("plane", even(0.006)), fresh("plane", even(0.006));
  for (double z = 0.03; z > kRadius - 0.002; z -= 1e-4) bench.at({0.001, 0.002, z});
  bench.model->reset();
  Vector3d felt = Vector3d::Zero();
  for (double z = kRadius + 0.001; z > kRadius - 0.004; z -= 1e-4) {
    felt = bench.at({0.001, 0.002, z}).wrench.force;
    ASSERT_EQ(felt, fresh.at({0.001, 0.002, z}).wrench.force) << z;
  }
  EXPECT_NEAR(felt.z(), kStiffness * 0.004, 0.1 * kStiffness * 0.004);
}

constexpr double kArm = 0.06;

/// Two balls on a rod along x, the handle in its middle.
Tool dumbbell() {
  const Eigen::Quaterniond straight = Eigen::Quaterniond::Identity();
  return Tool({{"left", Vector3d::Constant(kRadius), {{-kArm, 0, 0}, straight}},
               {"rod", {kArm, 0.006, 0.006}, {}},
               {"right", Vector3d::Constant(kRadius), {{kArm, 0, 0}, straight}}});
}

TEST(ProxyForce, TwoBallsOnARodAreHeldWithoutATurn) {
  Bench bench("plane", even(0.004), {}, dumbbell());
  constexpr double kDepth = 0.005;
  const ForceOutput felt = press(bench, 0.01, 0.02, kRadius - kDepth);
  EXPECT_NEAR(felt.wrench.force.z(), kStiffness * kDepth, 0.07 * kStiffness * kDepth);
  EXPECT_LE(felt.wrench.force.head<2>().norm(), 0.03 * felt.wrench.force.z());
  EXPECT_LE(felt.wrench.torque.norm(), 0.03 * kArm * felt.wrench.force.z());
}

TEST(ProxyForce, OneOfTwoBallsOnARodTurnsTheHandle) {
  const Tool tool = dumbbell();
  constexpr double kDepth = 0.003;
  // The plane ends at x = 0.2, so that nothing is below the right ball.
  // What pushes up at x = -kArm turns about +y; of one plane, the nearest motion is exact: pushed by p, the
  // handle goes up by p and turns by p kArm / g^2, so that the ball comes up by p (1 + kArm^2 / g^2).
  for (const double g : {ProxyForce::kTurning * tool.gyration(), 0.05}) {
    ProxyParameters parameters;
    parameters.arm_max = g;
    Bench bench("plane", even(0.004), parameters, tool);
    const ForceOutput felt = press(bench, 0.2, 0.02, kRadius - kDepth);
    const double force = kStiffness * kDepth / (1.0 + kArm * kArm / (g * g));
    EXPECT_NEAR(felt.wrench.force.z(), force, 0.1 * force);
    EXPECT_NEAR(felt.wrench.torque.y(), kArm * felt.wrench.force.z(), 0.1 * kArm * force);
    EXPECT_NEAR(felt.wrench.torque.x(), 0.0, 0.03 * kArm * force);
    EXPECT_NEAR(felt.wrench.torque.z(), 0.0, 0.03 * kArm * force);
    EXPECT_NEAR(felt.angular_stiffness, felt.stiffness * g * g, 1e-9);
    EXPECT_FALSE(felt.at_lever);
  }
  ProxyParameters longer;
  longer.arm_max = 1.0;
  Bench own("plane", even(0.004), {}, tool), bounded("plane", even(0.004), longer, tool);
  const ForceOutput felt = press(own, 0.2, 0.02, kRadius - kDepth);
  EXPECT_EQ(press(bounded, 0.2, 0.02, kRadius - kDepth).wrench.force, felt.wrench.force);
}

TEST(ProxyForce, AnOpenHandRestsOnAPlane) {
  const Tool hand = read_tool(test::example_tool("open-hand"));
  Bench bench("plane", even(0.003), {}, hand);
  constexpr double kDepth = 0.005;
  const AllocationGuard guard;
  const ForceOutput felt = press(bench, -0.03, 0.0, hand.support(-Vector3d::UnitZ()) - kDepth);
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(felt.wrench.force.z(), 0.1 * kStiffness * kDepth);
  EXPECT_LE(degrees_between(felt.wrench.force, Vector3d::UnitZ()), 10.0);
  for (const ToolPart& part : hand.parts()) {
    EXPECT_LE(below_the_plane(part, felt.proxy), ProxyParameters::kDetailOfTool * part.semi_axes.minCoeff())
        << part.name;
  }
}

// Pressed in and drawn out at 0.5 m/s with 40 N s/m, 20 N against a spring of 10 N at most.
TEST(ProxyForce, DampingNeitherPullsNorPushesMoreThanTheSpringDoes) {
  ProxyParameters damping;
  damping.materials = everywhere({.damping = 40.0});
  Bench damped("plane", even(0.004), damping), plain("plane", even(0.004));
  constexpr double kStep = 5e-4;
  double most = 0.0;
  ForceInput input;
  input.dt = 1e-3;
  for (int tick = -60; tick <= 60; ++tick) {
    input.tool.position = {0.003, 0.001, kRadius - 0.010 + kStep * std::abs(tick)};
    input.velocity.linear = {0, 0, std::copysign(kStep / input.dt, tick)};
    const Vector3d force = damped.model->evaluate(input).wrench.force,
                   spring = plain.model->evaluate(input).wrench.force;
    const double along = force.dot(spring), rounding = 1e-9;
    EXPECT_GE(along, -rounding) << tick;
    EXPECT_LE(along, (tick <= 10 ? 2.0 : 1.0) * spring.squaredNorm() + rounding) << tick;
    EXPECT_NEAR(force.cross(spring).norm(), 0.0, rounding) << "it stays where it points";
    most = std::max(most, force.norm() / std::max(1.0, spring.norm()));
  }
  EXPECT_GT(most, 1.9) << "and it damps";
}

// A material of 40 N s/m through a device that shows 10 is one of 10.
TEST(ProxyForce, DampingIsNoMoreThanTheDeviceShows) {
  const auto force_with = [](double damping, double damping_max) {
    ProxyParameters parameters;
    parameters.materials = everywhere({.damping = damping});
    Bench bench("plane", even(0.004), parameters);
    ForceInput input;
    input.dt = 1e-3;
    input.damping_max = damping_max;
    Vector3d force;
    for (int tick = 0; tick <= 60; ++tick) {
      input.tool.position = {0.003, 0.001, kRadius + 0.005 - 2e-4 * tick};
      input.velocity.linear = {0, 0, -0.2};
      force = bench.model->evaluate(input).wrench.force;
    }
    return force;
  };
  const double unlimited = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(force_with(40.0, 10.0).isApprox(force_with(10.0, unlimited), 1e-12));
  EXPECT_GT(force_with(40.0, unlimited).z(), force_with(40.0, 10.0).z() + 1.0);
}

// A tool that is led over noise, in and out and to and fro: what it has got out of the surface and what may
// yet come is never more than there was when it began, and what the last force takes beyond all that is left
// while it fades out in a tick.
TEST(ProxyForce, MakesNoEnergyAsItSlides) {
  for (const char* shape : {"plane", "sphere", "torus"}) {
    Bench bench(shape, noisy(936));
    Random random(937);
    for (const SurfaceSample& s : test::smooth_places(*bench.surface, shape, 6, 938)) {
      bench.model->reset();
      Vector3d at = s.point + 1.5 * kRadius * s.normal, force = Vector3d::Zero();
      const double began = bench.at(at).stored_energy;
      double work = 0.0, left = began, beyond = 0.0;
      for (int leg = 0; leg < 12; ++leg) {
        const Vector3d other = s.normal.cross(s.tangent);
        const double along = random.uniform(-0.02, 0.02), across = random.uniform(-0.02, 0.02);
        const Vector3d aside = along * s.tangent + across * other;
        const Vector3d end = s.point + random.uniform(0.3, 1.1) * kRadius * s.normal + aside, begin = at;
        const int ticks = 20 + static_cast<int>(random.index(200));
        for (int tick = 1; tick <= ticks; ++tick) {
          const Vector3d next = begin + static_cast<double>(tick) / ticks * (end - begin);
          const ForceOutput felt = bench.at(next);
          beyond += std::max(0.0, 0.5 * force.dot(next - at) - left);
          work += 0.5 * (force + felt.wrench.force).dot(next - at);
          force = felt.wrench.force;
          left = felt.stored_energy;
          at = next;
          ASSERT_LE(work + left, began + beyond + 1e-12) << shape << " leg " << leg << " tick " << tick;
          ASSERT_TRUE(force.norm() > 0.0 || left <= began) << "what has been lost is not kept";
        }
      }
      EXPECT_LT(beyond, 0.05 * ProxyForce::kReserve) << shape;
    }
  }
}

// Nor does a long tool that is turned as it is led.
TEST(ProxyForce, MakesNoEnergyAsItTurns) {
  Bench bench("sphere", noisy(943), {.friction = 0.2}, Tool({0.01, 0.015, 0.03}));
  Random random(944);
  for (const SurfaceSample& s : test::smooth_places(*bench.surface, "sphere", 6, 945)) {
    bench.model->reset();
    ForceInput input;
    input.dt = 1e-3;
    input.tool.position = s.point + 0.05 * s.normal;
    ForceOutput last = bench.model->evaluate(input);
    const double began = last.stored_energy;
    double work = 0.0;
    for (int leg = 0; leg < 12; ++leg) {
      const Vector3d aside{random.normal(), random.normal(), random.normal()};
      const Vector3d end = s.point + random.uniform(-0.01, 0.03) * s.normal + 0.01 * aside;
      const Vector3d turn{random.normal(), random.normal(), random.normal()};
      const int ticks = 50 + static_cast<int>(random.index(200));
      const Vector3d step = (end - input.tool.position) / ticks;
      for (int tick = 0; tick < ticks; ++tick) {
        input.tool.position += step;
        input.tool.orientation = (rotation_by(turn / ticks) * input.tool.orientation).normalized();
        const ForceOutput felt = bench.model->evaluate(input);
        work += 0.5 * (felt.wrench.force + last.wrench.force).dot(step) +
                0.5 * (felt.wrench.torque + last.wrench.torque).dot(turn / ticks);
        ASSERT_LE(work + felt.stored_energy, began + 1e-9) << "leg " << leg << " tick " << tick;
        last = felt;
      }
    }
  }
}

TEST(ProxyForce, ForgetsHowFastTheToolWasWhenReset) {
  ProxyParameters damping;
  damping.materials = everywhere({.damping = 5.0});
  Bench used("plane", even(0.004), damping), fresh("plane", even(0.004), damping);
  ForceInput input;
  input.dt = 1e-3;
  input.tool.position = {0, 0, kRadius - 0.010};
  input.velocity.linear = {0, 0, -0.5};
  for (int tick = 0; tick < 20; ++tick) used.model->evaluate(input);
  used.model->reset();
  input.velocity.linear.setZero();
  EXPECT_EQ(used.model->evaluate(input).wrench.force, fresh.model->evaluate(input).wrench.force);
}

// A device that was lost for a moment: the way is longer than what a tick looks at.
TEST(ProxyForce, IsSoonWithAToolThatLeapsThroughTheAir) {
  Bench bench("plane", even(0.006));
  bench.at({-0.1, 0, 0.1});
  ForceOutput felt;
  for (int tick = 0; tick < 10; ++tick) felt = bench.at({0.8, 0, 0.1});
  EXPECT_NEAR((felt.proxy.position - Vector3d(0.8, 0, 0.1)).norm(), 0.0, 1e-12);
  EXPECT_EQ(felt.wrench.force, Vector3d(0, 0, 0));
}

// Where a tool has been in the air is nothing to what it meets: aslant on a plane, at once and after a metre
// along it.
TEST(ProxyForce, FeelsTheSameWhereverItComesFrom) {
  Bench near("plane", even(0.004)), far("plane", even(0.004));
  const Vector3d above(-0.03, 0.0, kRadius + 0.01);
  for (double way = 1.0; way > 0.0; way -= 1e-3) far.at(above - way * Vector3d::UnitX());
  for (double way = 0.0; way < 0.02; way += 1e-4) {
    const Vector3d at = above + way * Vector3d(1, 0, -1);
    const Vector3d force = near.at(at).wrench.force;
    EXPECT_NEAR((far.at(at).wrench.force - force).norm(), 0.0, 0.03 * kStiffness * 0.01) << way;
  }
  EXPECT_NEAR(near.at(above + 0.02 * Vector3d(1, 0, -1)).wrench.force.z(), kStiffness * 0.01,
              0.03 * kStiffness * 0.01);
}

TEST(ProxyForce, TakesNothingFromTheHeap) {
  Bench bench("sphere", noisy(935));
  bench.at({0, 0, 0.2});
  const AllocationGuard guard;
  Vector3d force;
  for (double z = 0.19; z > 0.13; z -= 1e-3) force = bench.at({0, 0, z}).wrench.force;
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(force.z(), 1.0);
}

/// A floor in z = 0, and a wall of it in x = 0.05.
std::vector<test::Splat> floor_and_wall() {
  std::vector<test::Splat> splats;
  const Eigen::Quaterniond upright = rotation_between(Vector3d::UnitZ(), Vector3d::UnitX());
  for (int i = -20; i <= 20; ++i) {
    for (int k = -10; k <= 10; ++k) {
      splats.push_back(test::splat({0.005 * i, 0.005 * k, 0.0}, {0.004, 0.004, 0.0002}));
      if (i >= 0)
        splats.push_back(test::splat({0.05, 0.005 * k, 0.005 * i}, {0.004, 0.004, 0.0002}, upright));
    }
  }
  return splats;
}

// However deep it is below the floor, and so wants to go down more than along.
TEST(ProxyForce, ABallThatSlidesOnAFloorStopsAtAWall) {
  const SceneIndex index(test::scene_of(floor_and_wall()), SceneFilter{}, Similarity{});
  for (const double depth : {0.001, 0.01, 0.08}) {
    for (const double friction : {0.0, 0.3}) {
      ProxyForce model(index, Tool(Vector3d::Constant(kRadius)),
                       {.stiffness = kStiffness, .friction = friction});
      ForceInput input;
      input.dt = 1e-3;
      for (double z = 2.0 * kRadius; z > kRadius - depth; z -= 1e-4) {
        input.tool.position = {-0.03, 0.001, z};
        model.evaluate(input);
      }
      double farthest = -1.0;
      ForceOutput felt;
      for (; input.tool.position.x() < 0.09; input.tool.position.x() += 1e-4) {
        felt = model.evaluate(input);
        farthest = std::max(farthest, felt.proxy.position.x());
      }
      EXPECT_NEAR(farthest, 0.05 - kRadius, 5e-4) << depth;
      EXPECT_NEAR(felt.wrench.force.x(), -kStiffness * 0.06, 0.02 * kStiffness * 0.06) << depth;
    }
  }
}

// 0.2 m long on splats 1 mm apart: one look costs more than a tick has, and is not begun again for ever.
TEST(ProxyForce, ALongRodOnADenseFloorIsFollowedAndLetGo) {
  std::vector<test::Splat> splats;
  for (int i = -110; i <= 110; ++i)
    for (int k = -20; k <= 20; ++k)
      splats.push_back(test::splat({0.001 * i, 0.001 * k, 0.0}, {0.0007, 0.0007, 0.0001}));
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  constexpr double kThin = 0.003;
  ProxyForce model(index, Tool(Vector3d(0.1, kThin, kThin)), {.stiffness = kStiffness});
  ForceInput input;
  input.dt = 1e-3;
  constexpr int kTicks = 20;
  const auto go = [&](double to) {
    const double from = input.tool.position.z();
    ForceOutput felt;
    for (int k = 1; k <= kTicks; ++k) {
      input.tool.position.z() = from + k * (to - from) / kTicks;
      felt = model.evaluate(input);
    }
    for (int k = 0; k < 200; ++k) felt = model.evaluate(input);
    return felt;
  };
  input.tool.position.z() = 0.1;
  model.evaluate(input);
  const ForceOutput pressed = go(-0.05);  // at 7.5 m/s
  EXPECT_NEAR(pressed.proxy.position.z(), kThin, 0.25 * kThin);
  constexpr double kLate = 2 * 0.15 / kTicks;  // two ticks, in which it has no time to look at all
  EXPECT_GT(pressed.wrench.force.z(), kStiffness * (0.05 + kThin - kLate));
  EXPECT_LT(pressed.wrench.force.z(), 1.01 * kStiffness * (0.05 + kThin));
  const ForceOutput left = go(0.1);
  EXPECT_EQ(left.wrench.force.norm(), 0.0);
  EXPECT_EQ(left.proxy.position, input.tool.position);
}

/// A floor at z = 0, splats 3 mm apart.
const SceneIndex& smooth_floor() {
  static const SceneIndex index(make_scene(*make_surface("plane"), even(0.003)), SceneFilter{}, Similarity{});
  return index;
}

/// Presses a tool that lies flat `depth` into smooth_floor(), and moves it on from there.
class Lies {
 public:
  Lies(const Tool& tool, double depth, const Vector3d& begin = Vector3d::Zero(), double friction = 0.0)
      : model_(smooth_floor(), tool, {.stiffness = kStiffness, .friction = friction}) {
    input_.dt = 1e-3;
    input_.tool.position = begin;
    const double flat = tool.support(-Vector3d::UnitZ()) - depth;
    for (double z = flat + 0.01; z > flat; z -= 1e-4) {
      input_.tool.position.z() = z;
      model_.evaluate(input_);
    }
  }
  /// As if it had never been anywhere else.
  ForceOutput begin_anew(const Vector3d& at) {
    model_.reset();
    input_.tool.position = at;
    return model_.evaluate(input_);
  }
  ForceOutput go(const Vector3d& by, const Vector3d& turn = Vector3d::Zero()) {
    input_.tool.position += by;
    input_.tool.orientation = (rotation_by(turn) * input_.tool.orientation).normalized();
    return model_.evaluate(input_);
  }

 private:
  ProxyForce model_;
  ForceInput input_;
};

// Rays along the floor that it lies on meet it far inside of the rod: that is no wall.
TEST(ProxyForce, AThinRodSlidesAlongItsOwnLength) {
  constexpr double kDepth = 0.0015;
  for (const double speed : {0.3, 0.8, 1.0, 1.5}) {
    for (const Vector3d& rod : {Vector3d(0.1, 0.003, 0.003), Vector3d(0.05, 0.002, 0.002)}) {
      Lies tool(Tool(rod), kDepth, {-0.08, 0.0, 0.0});
      const double step = 1e-3 * speed;
      ForceOutput felt;
      for (int k = 0; k < static_cast<int>(0.15 / step); ++k) {
        felt = tool.go({step, 0.0, 0.0});
        // What it may trail by: two ticks.
        ASSERT_LE(felt.wrench.force.head<2>().norm(), 2.0 * kStiffness * step) << speed << " m/s, tick " << k;
      }
      for (int k = 0; k < 50; ++k) felt = tool.go(Vector3d::Zero());
      EXPECT_NEAR(felt.wrench.force.head<2>().norm(), 0.0, 1e-3) << speed;
      EXPECT_NEAR(felt.wrench.force.z(), kStiffness * kDepth, 0.02 * kStiffness * kDepth) << speed;
    }
  }
}

// Its proxy turns as far as the tool does, also where not every tick has the time to look at all of its rim.
TEST(ProxyForce, APlateThatSpinsOnAFloorFeelsNoTorque) {
  const Vector3d plate(0.1, 0.1, 0.01);
  const double gyration = ProxyForce::kTurning * Tool(plate).gyration();
  for (const double rate : {2.0, 6.0, 9.0}) {  // rad/s
    Lies tool(Tool(plate), 0.004);
    ForceOutput felt;
    double most = 0.0;
    for (int k = 0; k < 600; ++k) {
      felt = tool.go(Vector3d::Zero(), {0.0, 0.0, 1e-3 * rate});
      most = std::max(most, felt.wrench.torque.norm());
    }
    constexpr double kTrails = 6e-3;  // s
    EXPECT_LT(most, kStiffness * gyration * gyration * kTrails * rate) << rate;
    for (int k = 0; k < 50; ++k) felt = tool.go(Vector3d::Zero());
    EXPECT_NEAR(felt.wrench.torque.norm(), 0.0, 1e-3) << rate;
    EXPECT_NEAR(felt.wrench.force.z(), kStiffness * 0.004, 0.02) << rate;
  }
}

// A tick has no time to look at all of the way of many parts, or of a small one that is fast; the proxy
// trails then, and makes up for it where the tool rests.
TEST(ProxyForce, AToolThatIsTooFastForATickIsNotDragged) {
  const Tool hand = read_tool(test::example_tool("open-hand")), ball(Vector3d::Constant(0.002));
  struct Slide {
    const Tool& tool;
    double depth, speed;  // m, m/s
  };
  for (const auto& [tool, depth, speed] : {Slide{hand, 0.005, 0.3}, Slide{hand, 0.005, 1.0},
                                           Slide{hand, 0.005, 5.0}, Slide{ball, 0.0006, 5.0}}) {
    for (const double friction : {0.0, 0.3}) {
      Lies lies(tool, depth, {-0.08, 0.0, 0.0}, friction);
      ForceOutput felt;
      for (int k = 0; k < 50; ++k) felt = lies.go(Vector3d::Zero());
      const double normal = felt.wrench.force.z(), near = 0.1 * normal;
      for (double x = 0.0; x < 0.12; x += 1e-3 * speed) {
        felt = lies.go({1e-3 * speed, 0.0, 0.0});
        ASSERT_LE(felt.wrench.force.head<2>().norm(), friction * felt.wrench.force.z() + near)
            << speed << " m/s, friction " << friction;
        ASSERT_NEAR(felt.wrench.force.z(), normal, near) << speed << " m/s, friction " << friction;
      }
      for (int k = 0; k < 150; ++k) felt = lies.go(Vector3d::Zero());
      EXPECT_LE(felt.wrench.force.head<2>().norm(), friction * normal + 0.1 * near) << speed;
    }
  }
}

// A tick that was to be continued in the next one is not, where the tool begins anew.
TEST(ProxyForce, WhatItHadNoTimeForEndsWithAReset) {
  const Tool hand = read_tool(test::example_tool("open-hand"));
  for (int ticks = 1; ticks <= 12; ++ticks) {
    Lies lies(hand, 0.005, {-0.08, 0.0, 0.0});
    for (int k = 0; k < ticks; ++k) lies.go({5e-3, 0.0, 0.0});
    const Vector3d above(0.0, 0.0, 0.4);
    const ForceOutput felt = lies.begin_anew(above);
    EXPECT_EQ(felt.proxy.position, above) << ticks;
    EXPECT_EQ(felt.wrench.force.norm(), 0.0);
  }
}

// What it did not have the time to look at, and finds out later, comes no faster than what it meets in time.
TEST(ProxyForce, ASurfaceThatIsFoundLateDoesNotJerk) {
  const Tool hand = read_tool(test::example_tool("open-hand")), plate(Vector3d(0.1, 0.1, 0.01));
  struct Slide {
    const Tool& tool;
    double speed;  // m/s
  };
  for (const auto& [tool, speed] : {Slide{hand, 0.5}, Slide{hand, 2.0}, Slide{plate, 0.5}}) {
    for (const double y : {0.0, 0.015}) {
      Bench bench("step", even(0.003), {}, tool);
      const double step = 1e-3 * speed, flat = tool.support(-Vector3d::UnitZ()) - 0.006;
      Vector3d place(-0.05, y, flat + 0.01);
      for (; place.z() > flat; place.z() -= 5e-5) bench.at(place);
      Vector3d before = bench.at(place).wrench.force;
      double most = 0.0;
      for (; place.x() < 0.05; place.x() += step) {
        const Vector3d force = bench.at(place).wrench.force;
        most = std::max(most, (force - before).norm());
        before = force;
      }
      EXPECT_LE(most, kStiffness * (2.0 * step + 1e-4)) << speed << " m/s, y " << y;
    }
  }
}

// Past a floor, a millimetre above it, and then straight down: where it has been going to is not where it
// goes.
TEST(ProxyForce, LooksWhereItGoesAfterATurn) {
  constexpr double kAbove = 0.001, kDepth = 0.005;
  for (const double before : {0.0, 0.002, 0.1}) {
    for (const double step : {1e-4, 1e-3, 5e-3}) {
      Bench bench("plane", even(0.004));
      for (double x = -before; x < 0.0; x += 1e-4) bench.at({x, 0.001, kRadius + kAbove});
      for (double z = kRadius + kAbove; z > kRadius - kDepth; z -= step) {
        const ForceOutput felt = bench.at({0.0, 0.001, z});
        ASSERT_GT(felt.proxy.position.z(), kRadius - 1e-4) << before << " at " << z;
      }
      EXPECT_NEAR(bench.at({0.0, 0.001, kRadius - kDepth}).wrench.force.z(), kStiffness * kDepth,
                  0.02 * kStiffness * kDepth)
          << before;
    }
  }
}

// One Gaussian as a plane, so that nothing but the proxy may be where it should not: at the tick in which it
// meets it, too, however that falls.
TEST(ProxyForce, DoesNotEnterAPlaneInAnyTick) {
  const SceneIndex index(
      test::scene_of({test::splat({0, 0, 0}, {0.5, 0.5, 1e-6}, Eigen::Quaterniond::Identity(), 0.95)}),
      SceneFilter{}, Similarity{});
  for (const double step : {3e-5, 1e-4, 1e-3, 5e-3}) {
    for (const double phase : {0.0, 0.25, 0.5, 0.75}) {
      ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kStiffness});
      ForceInput input;
      input.dt = 1e-3;
      for (int tick = 0; kRadius + 0.01 - (tick + phase) * step > 0.01; ++tick) {
        const double z = kRadius + 0.01 - (tick + phase) * step;
        input.tool.position = {0.001, 0.002, z};
        ASSERT_GT(model.evaluate(input).proxy.position.z(), kRadius - 1e-6) << step << " at " << z;
      }
    }
  }
}

// Off the end of a sheet, 10 mm under it, at 1 m/s: what is not held any more comes after the tool twice as
// fast as that moves.
TEST(ProxyForce, ComesAfterTheToolTwiceAsFastWhereNothingHoldsIt) {
  constexpr double kStep = 1e-3, kDepth = 0.010;
  Bench bench("plane", even(0.004));
  Vector3d at(0.15, 0.001, kRadius + 0.002);
  for (; at.z() > kRadius - kDepth; at.z() -= kStep) bench.at(at);
  Vector3d last = bench.at(at).proxy.position;
  double most = 0.0;
  for (; at.x() < 0.25; at.x() += kStep) {
    const Vector3d proxy = bench.at(at).proxy.position;
    most = std::max(most, (proxy - last).norm());
    last = proxy;
  }
  EXPECT_NEAR(last.z(), kRadius - kDepth, 1e-3) << "it has left the sheet";
  EXPECT_NEAR(most, 2.0 * kStep, 0.02 * kStep);
}

TEST(TheLocalSurface, IsMadeOfWhatTheToolIsHeldBy) {
  ProxyParameters parameters;
  parameters.friction = 0.2;
  parameters.materials = everywhere({.stiffness = 800.0, .friction = 0.4, .damping = 30.0});
  for (const double damping_max : {10.0, 100.0}) {
    Bench bench("plane", even(0.004), parameters);
    ForceInput input;
    input.dt = 1e-3;
    input.damping_max = damping_max;
    ForceOutput felt;
    for (int tick = 0; tick <= 60; ++tick) {
      input.tool.position = {0.003, 0.001, kRadius + 0.005 - 1e-4 * tick};
      felt = bench.model->evaluate(input);
      if (felt.local.count > 0) continue;
      EXPECT_EQ(felt.local.friction, 0.2) << "of no material where there is none";
      EXPECT_EQ(felt.local.damping, 0.0);
    }
    ASSERT_GE(felt.local.count, 1U);
    EXPECT_NEAR(felt.local.stiffness, 800.0, 1e-9);
    EXPECT_NEAR(felt.local.friction, 0.4, 1e-9);
    EXPECT_NEAR(felt.local.damping, std::min(30.0, damping_max), 1e-9) << "no more than the device shows";
  }
}

// So fine a detail, of Gaussians so small, that what is seen ends a few tenths of a millimetre below the
// ball: it goes on from there only once it has looked again, wherever it began.
TEST(ProxyForce, GoesNoFartherThanItSees) {
  std::vector<test::Splat> splats;
  for (int i = -30; i <= 30; ++i)
    for (int k = -30; k <= 30; ++k)
      splats.push_back(test::splat({1.2e-4 * i, 1.2e-4 * k, 0.0}, {1e-4, 1e-4, 1e-6}));
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  for (const double step : {2e-5, 1e-4}) {
    for (int k = 0; k < 10; ++k) {
      ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kStiffness, .detail = 0.001});
      ForceInput input;
      input.dt = 1e-3;
      for (double z = kRadius + 0.001 + 5e-5 * k; z > kRadius - 0.001; z -= step) {
        input.tool.position = {3e-5, 1e-5, z};
        ASSERT_GT(model.evaluate(input).proxy.position.z(), kRadius - 5e-5) << k << " at " << z;
      }
    }
  }
}

// A ball that is pulled off so fast that its last force, as it fades out, takes more than the spring had: the
// reserve pays for it.
TEST(ProxyForce, TheReservePaysForAForceThatFadesOutPastTheSurface) {
  constexpr double kPress = 2.5e-4, kPull = 1.5e-3, kStep = 1e-5;
  Bench bench("plane", even(0.004));
  double z = kRadius + 1e-3, work = 0.0, force = 0.0;
  const double began = bench.at({0.0, 0.0, z}).stored_energy;
  const auto go = [&](double up) {
    z += up;
    const ForceOutput felt = bench.at({0.0, 0.0, z});
    work += 0.5 * (force + felt.wrench.force.z()) * up;
    force = felt.wrench.force.z();
    return felt.stored_energy;
  };
  while (z > kRadius - kPress) go(-kStep);
  ASSERT_NEAR(force, kStiffness * kPress, 0.1 * kStiffness * kPress);
  const double left = go(kPull);
  EXPECT_EQ(force, 0.0);
  EXPECT_LE(work + left, began + 1e-12);
  EXPECT_GT(left, 0.0);
}

// What the proxy does by itself makes the spring longer by no more than the reserve, k (l^2 - l'^2) / 2: l'
// for the tool where it is, before the proxy moves.
TEST(ProxyForce, MakesTheSpringLongerByNoMoreThanTheReserve) {
  Random random(946);
  double most = 0.0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Bench bench("plane", noisy(seed));
    bool held = false;
    Vector3d at(0, 0, kRadius + 0.005), proxy = bench.at(at).proxy.position;
    for (int leg = 0; leg < 60; ++leg) {
      const Vector3d begin = at, end{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1),
                                     kRadius + random.uniform(-0.003, 0.003)};
      constexpr int kTicks = 50;
      for (int tick = 1; tick <= kTicks; ++tick) {
        at = begin + static_cast<double>(tick) / kTicks * (end - begin);
        const double before = (proxy - at).squaredNorm();
        proxy = bench.at(at).proxy.position;
        if (held) most = std::max(most, 0.5 * kStiffness * ((proxy - at).squaredNorm() - before));
        held = proxy != at;
      }
    }
  }
  EXPECT_LE(most, ProxyForce::kReserve * (1.0 + 1e-9));
  EXPECT_GT(most, 0.95 * ProxyForce::kReserve) << "and it has come to that";
}

// On a floor in a corner, both walls of which have been touched: what pushes is first, and then what is
// nearer, whichever of both has been met first.
TEST(TheLocalSurface, HasWhatMattersMoreFirst) {
  constexpr double kWall = 0.03, kDepth = 0.003;
  std::vector<test::Splat> splats;
  const Eigen::Quaterniond along_x = rotation_between(Vector3d::UnitZ(), Vector3d::UnitX()),
                           along_y = rotation_between(Vector3d::UnitZ(), Vector3d::UnitY());
  for (int i = -20; i <= 20; ++i)
    for (int k = -20; k <= 20; ++k) {
      const double a = 0.003 * i, b = 0.003 * k;
      const Vector3d semi_axes(0.002, 0.002, 1e-4);
      splats.push_back(test::splat({a, b, 0.0}, semi_axes, Eigen::Quaterniond::Identity(), 0.95));
      splats.push_back(test::splat({kWall, b, a}, semi_axes, along_x, 0.95));
      splats.push_back(test::splat({a, kWall, b}, semi_axes, along_y, 0.95));
    }
  const SceneIndex index(test::scene_of(splats), SceneFilter{}, Similarity{});
  const double touches = kWall - kRadius;
  for (const bool x_first : {false, true}) {
    for (const bool x_nearer : {false, true}) {
      ProxyForce model(index, Tool(Vector3d::Constant(kRadius)), {.stiffness = kStiffness});
      ForceInput input;
      input.dt = 1e-3;
      input.tool.position = {touches - 0.01, touches - 0.01, kRadius + 0.01};
      ForceOutput felt;
      const auto go_to = [&](const Vector3d& place) {
        while (input.tool.position != place) {
          const Vector3d left = place - input.tool.position;
          input.tool.position =
              left.norm() > 1e-4 ? Vector3d(input.tool.position + 1e-4 * left.normalized()) : place;
          felt = model.evaluate(input);
        }
      };
      const double below = kRadius - kDepth, off = touches - 0.004, on = touches + 0.001;
      go_to({off, off, below});
      go_to(x_first ? Vector3d(on, off, below) : Vector3d(off, on, below));
      go_to({on, on, below});
      ASSERT_EQ(felt.local.count, 3U);
      const double near = touches - 0.0005, far = touches - 0.0015;
      go_to(x_nearer ? Vector3d(near, far, below) : Vector3d(far, near, below));
      ASSERT_EQ(felt.local.count, 3U);
      EXPECT_GT(felt.local.planes[0].normal.z(), 0.99) << "which alone pushes";
      EXPECT_LT(felt.local.planes[1].normal[x_nearer ? 0 : 1], -0.99);
      EXPECT_LT(felt.local.planes[2].normal[x_nearer ? 1 : 0], -0.99);
    }
  }
}

}  // namespace
}  // namespace palpate

// The potential force: against its own potential, around closed paths, and against a surface of known depth.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/scene_index.h>
#include <palpate/haptics/field_force.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/study/procedural.h>
#include <support/allocation_guard.h>
#include <support/effort.h>
#include <support/random_scenes.h>
#include <support/random_tools.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::AllocationGuard;

/// A tool in a scene, asked for potential and wrench anywhere.
class Felt {
 public:
  Felt(const GaussianScene& scene, const Tool& tool)
      : index_(scene, SceneFilter{}, Similarity{}), tool_(tool), model_(tool, {.stiffness = 1000.0}) {}

  const ContactSet& contacts(const Pose& pose) {
    query(index_, tool_, pose, set_);
    return set_;
  }
  double potential(const Pose& pose) { return model_.potential(input(pose)); }
  Wrench wrench(const Pose& pose) { return model_.evaluate(input(pose)).wrench; }

 private:
  ForceInput input(const Pose& pose) {
    ForceInput in;
    in.tool = pose;
    in.contacts = &contacts(pose);
    return in;
  }

  SceneIndex index_;
  Tool tool_;
  FieldForce model_;
  ContactSet set_;
};

Eigen::Quaterniond turn(const Vector3d& by) {
  const double angle = by.norm();
  return angle > 0.0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, by / angle))
                     : Eigen::Quaterniond::Identity();
}

Pose moved(const Pose& pose, const Vector3d& by, const Vector3d& turned) {
  return {pose.position + by, turn(turned) * pose.orientation};
}

/// -dU along `by` and `turned` together: central differences of fourth order.
double numerical_slope(Felt& felt, const Pose& pose, const Vector3d& by, const Vector3d& turned, double h) {
  const auto u = [&](double s) { return felt.potential(moved(pose, s * by, s * turned)); };
  return -(8.0 * (u(h) - u(-h)) - (u(2.0 * h) - u(-2.0 * h))) / (12.0 * h);
}

/// The wrench at `pose` against the slopes of the potential, each kind on its own scale, as the one may be
/// zero for reasons of symmetry. `size` is that of the tool, [m].
void expect_gradient(Felt& felt, const Pose& pose, double size) {
  const Wrench wrench = felt.wrench(pose);
  const double scale_force = wrench.force.norm(), scale_torque = scale_force * size;
  for (int k = 0; k < 3; ++k) {
    const Vector3d axis = Vector3d::Unit(k);
    EXPECT_NEAR(numerical_slope(felt, pose, axis, Vector3d::Zero(), 1e-5), wrench.force[k],
                1e-5 * scale_force);
    EXPECT_NEAR(numerical_slope(felt, pose, Vector3d::Zero(), axis, 1e-4), wrench.torque[k],
                1e-5 * scale_torque);
  }
}

TEST(FieldForce, IsTheGradientOfItsPotential) {
  test::Random random(901);
  const GaussianScene scene = test::scene_of(test::sphere_of_splats(random, 20000));
  int compared = 0;
  for (int i = 0; i < 60; ++i) {
    const double size = random.log_uniform(0.03, 0.1);
    const Vector3d semi_axes = size * random.semi_axes(0.3, 1.0);
    Felt felt(scene, Tool{semi_axes});
    const double distance = 1.0 + random.uniform(-0.5, 1.0) * semi_axes.minCoeff();
    const Pose pose{distance * random.direction(), random.rotation()};
    if (felt.contacts(pose).contacts.size() < 3) continue;
    ++compared;
    expect_gradient(felt, pose, semi_axes.maxCoeff());
  }
  EXPECT_GT(compared, 40);
}

TEST(FieldForce, IsTheGradientOfItsPotentialForAToolOfManyParts) {
  test::Random random(905);
  const GaussianScene scene = test::scene_of(test::sphere_of_splats(random, 20000));
  int compared = 0;
  for (int i = 0; i < 30; ++i) {
    const Tool tool = test::random_tool(random, 2 + i % 6, random.log_uniform(0.03, 0.08));
    Felt felt(scene, tool);
    const Vector3d n = random.direction();
    const Pose pose{(1.0 + random.uniform(-0.5, 1.0) * tool.thinnest()) * n, random.rotation()};
    const ContactSet& contacts = felt.contacts(pose);
    if (contacts.contacts.size() < 3 || contacts.contacts.front().part == contacts.contacts.back().part)
      continue;
    ++compared;
    expect_gradient(felt, pose, tool.radius());
  }
  EXPECT_GT(compared, 15);
}

/// A smooth closed path of poses about `center`, s in [0, 1].
struct Loop {
  Pose center;
  Vector3d a, b, c, turn_a, turn_b;

  Pose at(double s) const {
    const double w = 2.0 * std::numbers::pi * s;
    return moved(center, std::cos(w) * a + std::sin(w) * b + std::sin(2.0 * w) * c,
                 std::cos(w) * turn_a + std::sin(w) * turn_b);
  }
};

TEST(FieldForce, DoesNoWorkAroundAClosedPath) {
  test::Random random(902);
  Felt felt(test::scene_of(test::sphere_of_splats(random, 20000)), Tool({0.06, 0.05, 0.08}));
  for (int i = 0; i < 5; ++i) {
    const auto some = [&](double size) { return Vector3d(size * random.direction()); };
    const Loop loop{{1.03 * random.direction(), random.rotation()},
                    some(0.03),
                    some(0.03),
                    some(0.01),
                    some(0.3),
                    some(0.3)};
    // The wrench against the path's own motion, at the middles of many short stretches: for a smooth periodic
    // integrand the error of that falls faster than any power of their number, and Gaussians that come and go
    // leave only kinks of high order.
    constexpr int kStretches = 40000;
    double work = 0.0, peak = 0.0;
    for (int k = 0; k < kStretches; ++k) {
      const double s = (k + 0.5) / kStretches, half = 0.5 / kStretches;
      const Pose here = loop.at(s), before = loop.at(s - half), after = loop.at(s + half);
      const Wrench wrench = felt.wrench(here);
      const Eigen::AngleAxisd turned(after.orientation * before.orientation.conjugate());
      work += wrench.force.dot(after.position - before.position) +
              turned.angle() * wrench.torque.dot(turned.axis());
      peak = std::max(peak, felt.potential(here));
    }
    ASSERT_GT(peak, 0.0);
    EXPECT_LE(std::abs(work), 1e-6 * peak);
  }
}

TEST(FieldForce, IsZeroWithoutContactAndBeginsSmoothly) {
  const auto surface = make_surface("plane");
  Felt felt(make_scene(*surface, {}), Tool({0.02, 0.02, 0.02}));
  double last = 0.0;
  bool touched = false;
  for (double z = 0.025; z > 0.010; z -= 1e-5) {
    const Pose pose{{0.01, 0.02, z}, Eigen::Quaterniond::Identity()};
    const double force = felt.wrench(pose).force.norm();
    if (felt.contacts(pose).contacts.empty()) {
      ASSERT_EQ(force, 0.0);
    } else {
      touched = true;
      ASSERT_LE(std::abs(force - last), 2.0 * 1000.0 * 1e-5) << "a jump at " << z;
    }
    last = force;
  }
  EXPECT_TRUE(touched);
}

TEST(FieldForce, StiffnessIsInNewtonsAMetreHoweverDenselyTheSceneWasTrained) {
  constexpr double kRadius = 0.02, kDepth = 0.010;
  const auto surface = make_surface("plane");
  for (const double spacing : {0.006, 0.003, 0.0015}) {
    ProceduralOptions options;
    options.spacing = spacing;
    Felt felt(make_scene(*surface, options), Tool{Vector3d::Constant(kRadius)});
    test::Random random(903);
    double sum = 0.0;
    constexpr int kPlaces = 200;
    for (int i = 0; i < kPlaces; ++i) {
      const Vector3d at{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), kRadius - kDepth};
      const Wrench wrench = felt.wrench({at, Eigen::Quaterniond::Identity()});
      EXPECT_GT(wrench.force.z(), 0.0);
      sum += wrench.force.z();
    }
    EXPECT_NEAR(sum / kPlaces, 1000.0 * kDepth, 0.15 * 1000.0 * kDepth) << "spacing " << spacing;
  }
}

/// What pushes the default tool up where it is `depth` inside an even plane, as a mean over places, over
/// depth times stiffness. It stands on the end of its long axis before it is `turned`; `height` is half of it
/// then.
double relative_stiffness(const Eigen::Quaterniond& turned, double height, double depth) {
  ProceduralOptions options;
  options.spacing = 0.002;
  Felt felt(make_scene(*make_surface("plane"), options), Tool{});
  test::Random random(906);
  double sum = 0.0;
  constexpr int kPlaces = 50;
  for (int i = 0; i < kPlaces; ++i) {
    const Vector3d at{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), height - depth};
    sum += felt.wrench({at, turned}).force.z();
  }
  return sum / (kPlaces * 1000.0 * depth);
}

TEST(FieldForce, IsAsStiffOnTheTipOfALongToolAsOnItsSide) {
  const Eigen::Quaterniond lying(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitX()));
  for (const double depth : {0.002, 0.005, 0.010}) {
    EXPECT_NEAR(relative_stiffness(Eigen::Quaterniond::Identity(), 0.04, depth), 1.0, 0.2) << depth;
    EXPECT_NEAR(relative_stiffness(lying, 0.02, depth), 1.0, 0.2) << depth;
  }
}

/// What a captured scene may be made of, in a box of half the width `half`: points, discs and needles, thick
/// and thin, of semi-axes up to `largest`.
std::vector<test::Splat> any_splats(test::Random& random, std::size_t count, double half, double largest) {
  std::vector<test::Splat> result;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d at = random.in_box(half);
    const Eigen::Quaterniond q = random.rotation();
    const double a = random.log_uniform(0.03, 1.0) * largest, thin = random.log_uniform(1e-5, 1e-2) * a;
    const Vector3d shapes[] = {{a, a, a}, {a, 0.7 * a, thin}, {a, thin, thin}, {a, a, 0.0}};
    const Vector3d& shape = shapes[random.integer(0, 3)];
    result.push_back(test::splat(at, shape, q, random.uniform(0.15, 0.99)));
  }
  return result;
}

Vector3d center_of(const test::Splat& splat) { return splat.position.cast<float>().cast<double>(); }

TEST(FieldForce, IsTheGradientOfItsPotentialWhereCentresMeet) {
  test::Random random(907);
  for (int i = 0; i < 40; ++i) {
    const double size = random.log_uniform(0.005, 0.05);
    const auto splats = any_splats(random, 30, 2.0 * size, 3.0 * size);
    const Tool tool = i % 3 == 0   ? Tool{Vector3d::Constant(size)}
                      : i % 3 == 1 ? Tool{Vector3d(size * random.semi_axes(0.3, 1.0))}
                                   : test::random_tool(random, 3, size);
    Felt felt(test::scene_of(splats), tool);
    const Eigen::Quaterniond q = random.rotation();
    const Vector3d part = q * tool.parts().front().pose.position;
    const double apart = random.log_uniform(1e-3, 0.5) * size;
    const Vector3d at = center_of(splats.front()) - part + apart * random.direction();
    const Pose pose{at, q};
    const Wrench wrench = felt.wrench(pose);
    const double scale = std::max(wrench.force.norm(), 0.01 * 1000.0 * size);
    for (int k = 0; k < 3; ++k) {
      const Vector3d axis = Vector3d::Unit(k), none = Vector3d::Zero();
      EXPECT_NEAR(numerical_slope(felt, pose, axis, none, 1e-5 * size), wrench.force[k], 1e-5 * scale);
      EXPECT_NEAR(numerical_slope(felt, pose, none, axis, 1e-5), wrench.torque[k], 1e-5 * scale * size);
    }
  }
}

/// The largest change of the force on the way through `at` in steps of `step`, over stiffness times `step`.
double steepest(Felt& felt, const Pose& at, const Vector3d& direction, double half_way, double step) {
  double most = 0.0;
  std::optional<Vector3d> last;
  for (double s = -half_way; s <= half_way; s += step) {
    const Vector3d force = felt.wrench(moved(at, s * direction, Vector3d::Zero())).force;
    if (last) most = std::max(most, (force - *last).norm() / (1000.0 * step));
    last = force;
  }
  return most;
}

/// The same over ways through the centres of the Gaussians of random scenes: fine steps about the centre, and
/// a millimetre all the way. \param tools makes one of about the size asked for
template <class MakeTool>
double steepest_through_centres(std::uint64_t seed, double largest, const MakeTool& make_tool) {
  test::Random random(seed);
  double most = 0.0;
  for (std::size_t scene = 0; scene < test::draws(12); ++scene) {
    const double size = scene % 2 == 0 ? 0.02 : 0.005;
    const auto splats = any_splats(random, scene % 3 == 0 ? 1 : 60, 2.0 * size, largest * size);
    const Tool tool = make_tool(random, size);
    Felt felt(test::scene_of(splats), tool);
    for (int i = 0; i < 6; ++i) {
      const Eigen::Quaterniond q = random.rotation();
      const Vector3d part = q * tool.parts()[i % tool.parts().size()].pose.position;
      const Pose at{center_of(splats[i % splats.size()]) - part, q};
      const Vector3d direction = random.direction();
      most = std::max(most, steepest(felt, at, direction, 0.05 * size, 1e-5));
      most = std::max(most, steepest(felt, at, direction, 1.2 * size, 1e-3));
    }
  }
  return most;
}

// What docs/force-models.md states, with room above the worst of 210 other seeds: 14, 26 and 75. With a cone
// as e, where its tip is crossed, this is 1200 to 10000, and grows as the steps get finer.
TEST(FieldForce, IsNoSteeperThanAFewTimesItsStiffness) {
  const auto ball = [](test::Random&, double size) { return Tool{Vector3d::Constant(size)}; };
  const auto long_one = [](test::Random&, double size) { return Tool{{size, size, 2.0 * size}}; };
  const auto many = [](test::Random& random, double size) { return test::random_tool(random, 5, size); };
  for (const std::uint64_t seed : {908, 909, 910, 911})
    for (const double largest : {1.0, 3.0}) {
      EXPECT_LE(steepest_through_centres(seed, largest, ball), 16.0) << "seed " << seed;
      EXPECT_LE(steepest_through_centres(seed, largest, long_one), 32.0) << "seed " << seed;
      EXPECT_LE(steepest_through_centres(seed, largest, many), 96.0) << "seed " << seed;
    }
}

TEST(FieldForce, IsNoSteeperOnASurfaceHoweverItIsSampled) {
  for (const char* shape : {"sphere", "box", "shell"}) {
    const auto surface = make_surface(shape);
    for (const double spacing : {0.006, 0.004}) {
      ProceduralOptions options;
      options.spacing = spacing;
      options.noise = 0.0015;
      options.tilt = std::numbers::pi / 18.0;
      const GaussianScene scene = make_scene(*surface, options);
      test::Random random(912);
      for (const double radius : {0.02, 0.005}) {
        Felt felt(scene, Tool{Vector3d::Constant(radius)});
        for (std::size_t i = 0; i < test::draws(10); ++i) {
          const auto at = static_cast<std::size_t>(random.integer(0, static_cast<int>(scene.size()) - 1));
          const Pose through{scene.position[at].cast<double>(), random.rotation()};
          const Vector3d direction = random.direction();
          EXPECT_LE(steepest(felt, through, direction, 0.05 * radius, 1e-5), 6.0) << shape << " " << at;
          EXPECT_LE(steepest(felt, through, direction, 1.2 * radius, 1e-4), 6.0) << shape << " " << at;
        }
      }
    }
  }
}

TEST(FieldForce, OfOneGaussianIsNoSteeperThanDerived) {
  // D = 5/4 phi(g) r: of the stiffness of D^2 / 2 at the centre, (5/4)^2 phi(0) phi''(0) r^2 = 25/16 13/16 3.
  constexpr double kDerived = 25.0 / 16.0 * 13.0 / 16.0 * 3.0;
  Felt felt(test::scene_of({test::splat({0, 0, 0}, {1e-7, 1e-7, 1e-7})}), Tool{Vector3d::Constant(0.02)});
  test::Random random(913);
  double most = 0.0;
  for (int i = 0; i < 20; ++i) most = std::max(most, steepest(felt, {}, random.direction(), 0.0199, 1e-5));
  EXPECT_LE(most, kDerived * 1.0001);
  EXPECT_GE(most, kDerived * 0.999);
}

TEST(FieldForce, OfOneDiscIsSteeperTheLargerTheDisc) {
  constexpr double kRadius = 0.02, kStep = 1e-5;
  test::Random random(916);
  for (const double size : {0.25, 0.5, 1.0, 2.0, 5.0}) {
    Felt felt(test::scene_of({test::splat({0, 0, 0}, {size * kRadius, size * kRadius, 1e-7})}),
              Tool{Vector3d::Constant(kRadius)});
    for (std::size_t i = 0; i < test::draws(2000); ++i) {
      const Vector3d at = (1.0 + size) * kRadius * random.in_box(1.0).cwiseProduct(Vector3d(1.0, 1.0, 0.3));
      EXPECT_LE(steepest(felt, {at, Eigen::Quaterniond::Identity()}, random.direction(), kStep, kStep),
                14.0 + 2.0 * size * size);
    }
  }
}

TEST(FieldForce, InItsFirstHalfRadiusABallIsAsDeepAsWithoutTheRounding) {
  test::Random random(914);
  const GaussianScene scene = make_scene(*make_surface("sphere"), {});
  const SceneIndex index(scene, SceneFilter{}, Similarity{});
  for (int i = 0; i < 50; ++i) {
    const Tool tool(Vector3d::Constant(random.log_uniform(0.01, 0.03)));
    const double distance = 0.15 + random.uniform(0.55, 1.0) * tool.thinnest();
    const Pose pose{distance * random.direction(), random.rotation()};
    ContactSet set;
    query(index, tool, pose, set);
    if (set.contacts.empty()) continue;
    double weight = 0.0, weighted = 0.0;
    for (const Contact& c : set.contacts) {
      const double x = tool.thinnest() * (1.0 - std::sqrt(1.0 - c.k_min));
      weight += c.opacity * std::pow(x, 3);
      weighted += c.opacity * std::pow(x, 4);
    }
    EXPECT_NEAR(field_depth(set, tool, pose).depth, 1.25 * weighted / weight, 1e-9);
  }
}

TEST(FieldForce, OfOneGaussianIsNeverMoreThanTheDeviceCanShow) {
  const SceneIndex index(test::scene_of({test::splat({0, 0, 0}, {0.004, 0.002, 1e-5})}), SceneFilter{},
                         Similarity{});
  const Tool tool{Vector3d::Constant(0.02)};
  FieldForce model(tool, {.stiffness = 1000.0});
  test::Random random(915);
  ContactSet set;
  double most = 0.0;
  for (int i = 0; i < 2000; ++i) {
    ForceInput input;
    input.tool = {random.vector(0.0, 0.025), random.rotation()};
    query(index, tool, input.tool, set);
    input.contacts = &set;
    input.force_max = 3.3;
    most = std::max(most, model.evaluate(input).wrench.force.norm());
  }
  EXPECT_LE(most, 3.3);
  EXPECT_GT(most, 3.0);
}

// Of the spring where one is felt, and none where nothing is touched.
TEST(FieldForce, TellsItsStiffnessWhereItIsFelt) {
  ContactSet touched, none;
  const auto surface = make_surface("plane");
  const SceneIndex index(make_scene(*surface, {}), SceneFilter{}, Similarity{});
  const Tool tool(Vector3d::Constant(0.02));
  FieldForce model(tool, {.stiffness = 700.0});
  ForceInput input;
  input.tool.position = {0.01, 0.02, 0.015};
  query(index, tool, input.tool, touched);
  input.contacts = &touched;
  const ForceOutput felt = model.evaluate(input);
  EXPECT_EQ(felt.stored_energy, model.potential(input));
  EXPECT_EQ(felt.stiffness, 700.0);
  EXPECT_DOUBLE_EQ(felt.angular_stiffness, 700.0 * 0.02 * 0.02);
  EXPECT_TRUE(felt.at_lever);
  EXPECT_EQ(felt.confidence, 1.0);
  input.contacts = &none;
  EXPECT_EQ(model.evaluate(input).stiffness, 0.0);
  EXPECT_EQ(model.evaluate(input).angular_stiffness, 0.0);
}

TEST(FieldForce, HasNoForceWhereCentresCoincide) {
  Felt felt(test::scene_of({test::splat({0, 0, 0}, {0.01, 0.01, 0.01})}), Tool({0.02, 0.02, 0.02}));
  const Wrench wrench = felt.wrench({});
  EXPECT_EQ(wrench.force, Vector3d(0, 0, 0));
  EXPECT_EQ(wrench.torque, Vector3d(0, 0, 0));
}

TEST(FieldForce, TakesNothingFromTheHeap) {
  test::Random random(904);
  const SceneIndex index(test::scene_of(test::sphere_of_splats(random, 2000)), SceneFilter{}, Similarity{});
  const Tool tool({0.1, 0.1, 0.1});
  ForceInput input;
  input.tool.position = {0, 0, 1.05};
  ContactSet set;
  query(index, tool, input.tool, set);
  input.contacts = &set;
  ASSERT_FALSE(set.contacts.empty());
  FieldForce model(tool);
  const AllocationGuard guard;
  const Wrench wrench = model.evaluate(input).wrench;
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(wrench.force.z(), 0.0);
}

}  // namespace
}  // namespace palpate

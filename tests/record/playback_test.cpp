// Playback: what the force model is told, and that threads change nothing.
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <palpate/collision/scene_index.h>
#include <palpate/geometry/rotation.h>
#include <palpate/haptics/density_force.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/record/playback.h>
#include <support/splats.h>

namespace palpate::test {
namespace {

using Eigen::Vector3d;

TimedPose at(double t, const Vector3d& position,
             const Eigen::Quaterniond& q = Eigen::Quaterniond::Identity()) {
  return {t, {position, q}, {}};
}

Eigen::Quaterniond turn(double angle, const Vector3d& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()));
}

TEST(VelocityBetween, LinearByHand) {
  const Twist v = velocity_between(at(1.0, {1, 2, 3}), at(1.5, {2, 2, 2}));
  EXPECT_EQ(v.linear, Vector3d(2, 0, -2));
  EXPECT_EQ(v.angular, Vector3d(0, 0, 0));
}

TEST(VelocityBetween, AngularIsInTheWorldFrame) {
  // The tool, already turned about x, turns on by 0.2 rad about the world's z in 0.1 s.
  const Eigen::Quaterniond before = turn(std::numbers::pi / 2, Vector3d::UnitX());
  const Twist v =
      velocity_between(at(0, {0, 0, 0}, before), at(0.1, {0, 0, 0}, turn(0.2, {0, 0, 1}) * before));
  EXPECT_LT((v.angular - Vector3d(0, 0, 2)).norm(), 1e-13);
}

TEST(VelocityBetween, TakesTheShortWayRoundWhateverTheSignOfTheQuaternion) {
  Eigen::Quaterniond after = turn(0.3, {1, 2, 3});
  after.coeffs() *= -1.0;  // the same orientation
  const Twist v = velocity_between(at(0, {0, 0, 0}), at(0.5, {0, 0, 0}, after));
  EXPECT_LT((v.angular - 0.6 * Vector3d(1, 2, 3).normalized()).norm(), 1e-13);
}

TEST(VelocityBetween, SmallTurnsKeepTheirDigits) {
  const Twist v = velocity_between(at(0, {0, 0, 0}), at(1e-3, {0, 0, 0}, turn(1e-9, {0, 1, 0})));
  EXPECT_NEAR(v.angular.y(), 1e-6, 1e-12);
}

TEST(VelocityBetween, IsZeroIfNoTimePassed) {
  const Twist v = velocity_between(at(1, {0, 0, 0}), at(1, {1, 1, 1}, turn(1, {1, 0, 0})));
  EXPECT_EQ(v.linear, Vector3d(0, 0, 0));
  EXPECT_EQ(v.angular, Vector3d(0, 0, 0));
}

/// Notes what it is told, and answers with the number of its call.
class Witness final : public ForceModel {
 public:
  void reset() override { ++resets; }
  ForceOutput evaluate(const ForceInput& input) override {
    inputs.push_back(input);
    colliding.push_back(input.contacts->contacts.size());
    return {{Vector3d(static_cast<double>(inputs.size()), 0, 0), Vector3d(0, 1, 0)}, input.tool};
  }
  int resets = 0;
  std::vector<ForceInput> inputs;
  std::vector<std::size_t> colliding;
};

/// A ball of radius 0.1 m at the origin, id 42.
SceneIndex one_ball() {
  GaussianScene scene = scene_of({splat({0, 0, 0}, {0.1, 0.1, 0.1}, Eigen::Quaterniond::Identity(), 0.5)});
  scene.id = {42};
  return SceneIndex(scene, {}, {});
}

TEST(PlayBack, TellsTheModelEveryPoseInOrder) {
  Trajectory path{at(0, {1, 0, 0}), at(0.5, {0.1, 0, 0}), at(0.75, {0.05, 0, 0})};
  path[1].user_force = Vector3d(1, 2, 3);
  Witness witness;
  const auto rows = play_back(one_ball(), Tool({0.02, 0.02, 0.02}), witness, path);
  EXPECT_EQ(witness.resets, 1);
  ASSERT_EQ(witness.inputs.size(), 3U);
  EXPECT_EQ(witness.inputs[0].dt, 0.0);
  EXPECT_EQ(witness.inputs[0].velocity.linear, Vector3d(0, 0, 0));
  EXPECT_EQ(witness.inputs[1].dt, 0.5);
  EXPECT_LT((witness.inputs[1].velocity.linear - Vector3d(-1.8, 0, 0)).norm(), 1e-15);
  EXPECT_LT((witness.inputs[2].velocity.linear - Vector3d(-0.2, 0, 0)).norm(), 1e-15);
  EXPECT_EQ(witness.inputs[2].tool.position, Vector3d(0.05, 0, 0));
  EXPECT_EQ(witness.colliding, (std::vector<std::size_t>{0, 1, 1}));

  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[2].t, 0.75);
  EXPECT_EQ(rows[2].tool.position, Vector3d(0.05, 0, 0));
  EXPECT_EQ(rows[2].wrench.force, Vector3d(3, 0, 0));
  EXPECT_EQ(rows[2].wrench.torque, Vector3d(0, 1, 0));
  EXPECT_EQ(rows[2].proxy, Vector3d(0.05, 0, 0));
  EXPECT_EQ(rows[0].colliding, 0U);
  EXPECT_EQ(rows[0].candidates, 0U);
  EXPECT_EQ(rows[0].k_max, 0.0);
  EXPECT_EQ(rows[2].colliding, 1U);
  // Two balls: K_min = 1 - (d / (r1 + r2))^2. The scene has 0.1 as a float.
  const double ratio = 0.05 / (static_cast<double>(0.1F) + 0.02);
  EXPECT_NEAR(rows[2].k_max, 1 - ratio * ratio, 1e-12);
  EXPECT_GT(rows[2].compute_us, 0.0);
  EXPECT_FALSE(rows[0].user_force.has_value());
  EXPECT_EQ(rows[1].user_force, Vector3d(1, 2, 3));
}

/// 3000 flat Gaussians on a sphere of radius 0.15 m.
SceneIndex ball_of_splats() {
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  std::vector<Splat> splats;
  for (std::uint32_t k = 0; k < 3000; ++k) {
    const double x = normal(random), y = normal(random), z = normal(random);
    const Vector3d n = Vector3d(x, y, z).normalized();
    splats.push_back(splat(0.15 * n, {0.006, 0.006, 1e-4}, rotation_between(Vector3d::UnitZ(), n),
                           0.2 + 0.7 * std::abs(std::sin(k))));
  }
  return SceneIndex(with_gaps_in_ids(scene_of(splats)), {}, {});
}

/// Strokes over the ball, 10,000 poses: more than two of playback's blocks.
Trajectory strokes() {
  Trajectory path;
  for (int k = 0; k < 10000; ++k) {
    const double t = 1e-3 * k;
    const Vector3d n(std::sin(7 * t), std::cos(7 * t), std::sin(0.9 * t));
    path.push_back(at(t, (0.17 + 0.03 * std::sin(2 * t)) * n.normalized(), turn(t, {1, 1, 0})));
  }
  return path;
}

/// Every number of a row but the time it took, as bits.
std::vector<std::uint64_t> bits_of(const RunRow& r) {
  std::vector<std::uint64_t> bits{r.candidates, r.filtered, r.colliding};
  const auto add = [&](double v) { bits.push_back(std::bit_cast<std::uint64_t>(v)); };
  add(r.t);
  add(r.k_max);
  for (const double v : r.tool.position) add(v);
  for (const double v : r.tool.orientation.coeffs()) add(v);
  for (const Vector3d& w : {r.wrench.force, r.wrench.torque, r.proxy})
    for (const double v : w) add(v);
  return bits;
}

TEST(PlayBack, ThreadsChangeNotOneBit) {
  const SceneIndex index = ball_of_splats();
  const Trajectory path = strokes();
  DensityForce model;
  std::vector<RunRow> first;
  for (const std::size_t threads : {1, 2, 4, 1}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto rows = play_back(index, {}, model, path);
    if (first.empty()) first = rows;
    ASSERT_EQ(rows.size(), path.size());
    for (std::size_t i = 0; i < rows.size(); ++i) ASSERT_EQ(bits_of(rows[i]), bits_of(first[i])) << i;
  }
  std::size_t touching = 0;
  for (const RunRow& row : first) touching += row.colliding > 0 ? 1 : 0;
  EXPECT_GT(touching, 1000U);
  EXPECT_LT(touching, 9900U);
}

TEST(PlayBack, AgreesWithOneCallAPose) {
  const SceneIndex index = ball_of_splats();
  const Trajectory path = strokes();
  DensityForce model, alone;
  const auto rows = play_back(index, {}, model, path);
  ContactSet set;
  for (std::size_t i = 0; i < path.size(); ++i) {
    query(index, Tool{}, path[i].pose, set);
    const TimedPose& before = path[i > 0 ? i - 1 : 0];
    const Wrench w =
        alone.evaluate({path[i].pose, velocity_between(before, path[i]), path[i].t - before.t, &set}).wrench;
    ASSERT_EQ(rows[i].colliding, set.contacts.size()) << i;
    ASSERT_EQ(rows[i].wrench.force, w.force) << i;
  }
}

TEST(PlayBack, ForgetsAnEarlierRun) {
  const SceneIndex index = ball_of_splats();
  const Trajectory path = strokes();
  DensityForce model;
  const auto first = play_back(index, {}, model, path);
  const auto second = play_back(index, {}, model, path);  // the model's filters hold the end of the first
  EXPECT_EQ(bits_of(first[0]), bits_of(second[0]));
  EXPECT_EQ(bits_of(first.back()), bits_of(second.back()));
}

TEST(PlayBack, ReportsProgressToTheEnd) {
  Witness witness;
  std::vector<double> fractions;
  play_back(one_ball(), {}, witness, strokes(), [&](std::string_view, double f) { fractions.push_back(f); });
  ASSERT_GE(fractions.size(), 2U);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
}

TEST(PlayBack, AnEmptyTrajectoryGivesNoRows) {
  Witness witness;
  EXPECT_TRUE(play_back(one_ball(), {}, witness, {}).empty());
}

}  // namespace
}  // namespace palpate::test

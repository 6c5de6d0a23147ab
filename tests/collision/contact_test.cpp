// Normal, point and depth of a contact: by hand, against 113-bit arithmetic, and against what they mean.

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/contact.h>
#include <support/k_oracle.h>
#include <support/random_pairs.h>
#include <support/solids.h>

namespace palpate {
namespace {

using test::ball;
using test::ellipsoid;
using test::LiteralPaper;
using test::moved_to_k_min;
using test::oracle_minimum;
using test::OracleMinimum;
using test::Pair;
using test::PairOracle;
using test::Quad;
using test::Solid;
using test::Vec3;

Eigen::Vector3d to_double(const Vec3<Quad>& v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

Contact contact_of(const Ellipsoid& tool, const Ellipsoid& gaussian) {
  const WhitenedTool whitened(tool);
  const KFunction k(whitened, gaussian);
  return make_contact(whitened, gaussian, k, minimize(k));
}

/// (x - c)^T S^-1 (x - c): at most 1 inside. For solids with a volume.
double level(const Ellipsoid& e, const Eigen::Vector3d& x) {
  return (e.axes.inverse() * (x - e.center)).squaredNorm();
}

/// A pair of about tool size with the given K_min.
Pair random_pair(test::Random& r, double k_min) {
  const Ellipsoid tool = r.ellipsoid(0.5, 0.02, 0.06);
  const Pose pose{tool.center, r.rotation()};
  Ellipsoid gaussian = Ellipsoid::from_semi_axes(pose, r.semi_axes(0.003, 0.06));
  const Eigen::Vector3d on_gaussian = gaussian.axes * r.direction(), on_tool = tool.axes * r.direction();
  gaussian.center -= on_gaussian + on_tool;
  return {tool, moved_to_k_min(tool, gaussian, k_min)};
}

/// Gradient of K_min in the tool centre, by central differences in Quad.
Eigen::Vector3d gradient(const Pair& pair) {
  const Quad h = 1e-9;
  const Quad t = oracle_minimum(pair.tool, pair.gaussian).t;
  Vec3<Quad> g;
  for (std::size_t i = 0; i < 3; ++i) {
    Solid<Quad> ahead(pair.tool), behind(pair.tool);
    const Solid<Quad> gaussian(pair.gaussian);
    ahead.center[i] += h;
    behind.center[i] -= h;
    g[i] = (PairOracle<Quad>(ahead, gaussian).minimize_near(t).k_min -
            PairOracle<Quad>(behind, gaussian).minimize_near(t).k_min) /
           (2 * h);
  }
  return to_double(g);
}

TEST(ContactNormal, IsAgainstTheGradientOfKMin) {
  test::Random random(51);
  double worst = 0.0;
  for (int i = 0; i < 150; ++i) {
    const Pair pair =
        random_pair(random, i % 2 == 0 ? random.log_uniform(1e-9, 0.1) : random.uniform(0.1, 0.95));
    const Contact contact = contact_of(pair.tool, pair.gaussian);
    EXPECT_NEAR(contact.normal.norm(), 1.0, 1e-15);
    worst = std::max(worst, (contact.normal + gradient(pair).normalized()).norm());
  }
  RecordProperty("worst_normal_error", testing::PrintToString(worst));
  EXPECT_LE(worst, 1e-7);  // lambda is found to 1e-9, which turns the normal as much times the size ratio
}

TEST(ContactNormal, AgreesWithQuadForFlatGaussians) {
  test::Random random(52);
  double worst = 0.0;
  for (const double thickness : {1e-5, 1e-7, 0.0}) {
    for (int i = 0; i < 300; ++i) {
      const Ellipsoid tool =
          Ellipsoid::from_semi_axes({random.in_box(0.5), random.rotation()}, {0.02, 0.02, 0.04});
      Ellipsoid gaussian =
          Ellipsoid::from_semi_axes({tool.center, random.rotation()}, {0.03, 0.01, thickness});
      const Eigen::Vector3d on_gaussian = gaussian.axes * random.direction();
      const Eigen::Vector3d on_tool = tool.axes * random.direction();
      gaussian.center -= on_gaussian + on_tool;
      gaussian = moved_to_k_min(tool, gaussian, random.log_uniform(1e-6, 0.9));
      const OracleMinimum<Quad> truth = oracle_minimum(tool, gaussian);
      const Contact contact = contact_of(tool, gaussian);
      const Eigen::Vector3d normal = to_double((1 / test::norm(truth.z)) * truth.z);
      worst = std::max(worst, (contact.normal - normal).norm());
      EXPECT_LE((contact.point - to_double(truth.point)).norm(), 1e-8);
    }
  }
  RecordProperty("worst_normal_error", testing::PrintToString(worst));
  EXPECT_LE(worst, 1e-6);
}

TEST(ContactNormal, PointsFromTheGaussianToTheTool) {
  test::Random random(53);
  for (int i = 0; i < 1000; ++i) {
    const Pair pair = random_pair(random, random.uniform(0.0, 0.99));
    const Contact contact = contact_of(pair.tool, pair.gaussian);
    // -dK/dd . d = 2 (1 - K_min): always on d's side.
    EXPECT_GT(contact.normal.dot(pair.tool.center - pair.gaussian.center), 0.0);
  }
  const Contact above = contact_of(ball({0, 0, 0.9}, 0.5), ball({0, 0, 0}, 0.5));
  EXPECT_EQ(above.normal, Eigen::Vector3d(0, 0, 1));
  // On a large flat splat the normal is the splat's, wherever on it.
  const Contact on_splat = contact_of(ball({0.3, -0.2, -0.01}, 0.02), ellipsoid({0, 0, 0}, {1, 1, 0}));
  EXPECT_NEAR((on_splat.normal - Eigen::Vector3d(0, 0, -1)).norm(), 0.0, 1e-12);
}

TEST(ContactPoint, IsEquationFive) {
  test::Random random(54);
  for (int i = 0; i < 200; ++i) {
    const Pair pair = random_pair(random, random.uniform(0.001, 0.95));
    const OracleMinimum<Quad> truth = oracle_minimum(pair.tool, pair.gaussian);
    const Eigen::Vector3d m = to_double(LiteralPaper(pair.tool, pair.gaussian).m(truth.lambda()));
    EXPECT_LE((contact_of(pair.tool, pair.gaussian).point - m).norm(), 1e-10);
  }
}

TEST(ContactPoint, IsInsideBothSolidsAndOnBothWhereTheyTouch) {
  test::Random random(55);
  for (int i = 0; i < 1000; ++i) {
    const double k_min = i % 2 == 0 ? random.uniform(0.01, 0.99) : 1e-10;
    const Pair pair = random_pair(random, k_min);
    const Eigen::Vector3d point = contact_of(pair.tool, pair.gaussian).point;
    // At the minimum both levels are 1 - K_min.
    EXPECT_NEAR(level(pair.tool, point), 1.0 - k_min, 1e-7);
    EXPECT_NEAR(level(pair.gaussian, point), 1.0 - k_min, 1e-6);
  }
}

TEST(ContactPoint, ByHand) {
  // Balls of 2 and 1 whose centres are 3 apart touch 2 from the one and 1 from the other.
  const Contact touch = contact_of(ball({0, 0, 0}, 2.0), ball({3, 0, 0}, 1.0));
  EXPECT_NEAR((touch.point - Eigen::Vector3d(2, 0, 0)).norm(), 0.0, 1e-8);
  // Nearer, it stays where it divides the line of centres 2 to 1.
  const Contact deep = contact_of(ball({0, 0, 0}, 2.0), ball({0, 1.5, 0}, 1.0));
  EXPECT_NEAR((deep.point - Eigen::Vector3d(0, 1, 0)).norm(), 0.0, 1e-8);
  // Over a disc it is on the disc, below the ball's centre. The ball is far from the disc's middle,
  // but far from its rim, too.
  const Contact on_disc = contact_of(ball({0.2, 0.1, 0.015}, 0.02), ellipsoid({0, 0, 0}, {0.5, 0.5, 0}));
  EXPECT_NEAR((on_disc.point - Eigen::Vector3d(0.2, 0.1, 0)).norm(), 0.0, 1e-12);
  const Contact on_point = contact_of(ball({0, 0, 0}, 1.0), ellipsoid({0.5, 0.25, 0.125}, {0, 0, 0}));
  EXPECT_NEAR((on_point.point - Eigen::Vector3d(0.5, 0.25, 0.125)).norm(), 0.0, 1e-15);
}

TEST(ContactDepth, ByHand) {
  // Balls: r1 + r2 - distance.
  EXPECT_NEAR(contact_of(ball({0, 0, 0}, 2.0), ball({1, 2, 0}, 1.0)).depth, 3.0 - std::sqrt(5.0), 1e-14);
  EXPECT_NEAR(contact_of(ball({0, 0, 0}, 1e-3), ball({1e3, 0, 0}, 1e3)).depth, 1e-3, 1e-12);
  // Aligned ellipsoids along an axis: the sum of the semi-axes on it less the distance.
  EXPECT_NEAR(contact_of(ellipsoid({0, 0, 0}, {0.5, 2, 0.1}), ellipsoid({0, 1.75, 0}, {4, 0.25, 3})).depth,
              0.5, 1e-14);
  // A ball that is 0.005 deep in a disc.
  EXPECT_NEAR(contact_of(ball({0.2, 0.1, 0.015}, 0.02), ellipsoid({0, 0, 0}, {0.5, 0.5, 0})).depth, 0.005,
              1e-12);
  // A point at 0.6 of the radius.
  EXPECT_NEAR(contact_of(ball({0, 0, 0}, 1.0), ellipsoid({0, 0.6, 0}, {0, 0, 0})).depth, 0.4, 1e-15);
}

TEST(ContactDepth, IsZeroAtTangency) {
  test::Random random(56);
  for (int i = 0; i < 500; ++i) {
    const Pair pair = random_pair(random, 1e-12);
    const double depth = contact_of(pair.tool, pair.gaussian).depth;
    EXPECT_NEAR(depth, 0.0, 1e-12);  // 1e-12 of some centimetres, and its rounding at 0.5 m
    EXPECT_GE(depth, -1e-15);
  }
}

TEST(ContactDepth, MovedByItAlongTheNormalTheToolIsOut) {
  test::Random random(57);
  for (int i = 0; i < 1000; ++i) {
    Pair pair = random_pair(random, i % 2 == 0 ? random.log_uniform(1e-9, 0.1) : random.uniform(0.1, 0.9999));
    if (i % 5 == 0) pair.gaussian.axes.col(i % 3).setZero();
    const Contact contact = contact_of(pair.tool, pair.gaussian);
    if (contact.k_min <= 0.0) continue;  // flattened to where it no longer touches
    pair.tool.center += contact.depth * contact.normal;
    EXPECT_LE(static_cast<double>(oracle_minimum(pair.tool, pair.gaussian).k_min), 1e-12);
  }
}

/// Least movement that separates the pair: min over unit n of h_tool(n) + h_gaussian(n) - n . d, by
/// dense search and refinement.
double separating_translation(const Pair& pair) {
  const Eigen::Vector3d d = pair.tool.center - pair.gaussian.center;
  const auto at = [&](const Eigen::Vector3d& n) {
    return pair.tool.support(n) + pair.gaussian.support(n) - n.dot(d);
  };
  constexpr int kDirections = 2000;
  Eigen::Vector3d best = Eigen::Vector3d::UnitZ();
  for (int i = 0; i < kDirections; ++i) {  // a Fibonacci sphere
    const double z = 1.0 - (2.0 * i + 1.0) / kDirections, r = std::sqrt(1.0 - z * z),
                 phi = i * 2.399963229728653;
    const Eigen::Vector3d n(r * std::cos(phi), r * std::sin(phi), z);
    if (at(n) < at(best)) best = n;
  }
  for (double step = 0.1; step > 1e-9; step *= 0.7) {
    const Eigen::Vector3d u = best.unitOrthogonal(), v = best.cross(u);
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d n =
          (best + step * (std::cos(i * M_PI / 4) * u + std::sin(i * M_PI / 4) * v)).normalized();
      if (at(n) < at(best)) best = n;
    }
  }
  return at(best);
}

TEST(ContactDepth, IsNeverLessThanTheSeparatingTranslation) {
  test::Random random(58);
  std::vector<double> shallow, deeper;
  for (int i = 0; i < 400; ++i) {
    const bool is_shallow = i % 2 == 0;
    const Pair pair =
        random_pair(random, is_shallow ? random.log_uniform(1e-4, 0.02) : random.uniform(0.02, 0.36));
    const double truth = separating_translation(pair);
    const double depth = contact_of(pair.tool, pair.gaussian).depth;
    EXPECT_GE(depth, truth - 1e-12);
    (is_shallow ? shallow : deeper).push_back(depth / truth);
  }
  std::sort(shallow.begin(), shallow.end());
  std::sort(deeper.begin(), deeper.end());
  std::printf(
      "  depth / separating translation: shallow median %.5f, p99 %.4f; up to 20 %% overlap median %.4f, p99 "
      "%.3f\n",
      shallow[100], shallow[198], deeper[100], deeper[198]);
  EXPECT_LE(shallow[100], 1.002);
  EXPECT_LE(shallow[198], 1.10);
  EXPECT_LE(deeper[100], 1.05);
  EXPECT_LE(deeper[198], 1.60);
}

TEST(Contact, OfCoincidentCentresIsFiniteAndTheWayIsAlongTheThinnestAxis) {
  test::Random random(59);
  const Eigen::Vector3d center(0.1, -0.2, 0.3);
  const Ellipsoid tool = ball(center, 0.02);
  const Eigen::Matrix3d R = random.rotation().toRotationMatrix();
  for (const double thickness : {1e-3, 1e-7}) {
    const Ellipsoid gaussian{center, R * Eigen::Vector3d(0.05, thickness, 0.03).asDiagonal()};
    const Contact contact = contact_of(tool, gaussian);
    EXPECT_EQ(contact.k_min, 1.0);
    EXPECT_EQ(contact.lambda, 0.5);
    EXPECT_EQ(contact.point, center);
    EXPECT_NEAR(std::abs(contact.normal.dot(R.col(1))), 1.0, 1e-14);
    EXPECT_NEAR(contact.depth, 0.02 + thickness, 1e-15);
    const Contact again = contact_of(tool, gaussian);
    EXPECT_EQ(again.normal, contact.normal);
    EXPECT_EQ(again.depth, contact.depth);
  }
  for (const Eigen::Vector3d& axes :
       {Eigen::Vector3d(0.05, 0, 0.03), Eigen::Vector3d(0, 0.05, 0), Eigen::Vector3d(0, 0, 0)}) {
    const Contact flat = contact_of(tool, {center, R * axes.asDiagonal()});
    EXPECT_NEAR(flat.normal.norm(), 1.0, 1e-14);
    EXPECT_GE(flat.depth, 0.02);
    EXPECT_LE(flat.depth, 0.0701);
    EXPECT_EQ(flat.point, center);
  }
}

// The way out of a disc through whose centre the tool passes is across the disc: 0.02, not the 0.02 + 0.03
// or more that an axis within the disc takes.
TEST(Contact, OfCoincidentCentresOnADiscIsAcrossTheDisc) {
  test::Random random(60);
  const Eigen::Matrix3d R = random.rotation().toRotationMatrix();
  const Contact contact =
      contact_of(ball({0, 0, 0}, 0.02), {{0, 0, 0}, R * Eigen::Vector3d(0.05, 0.03, 0.0).asDiagonal()});
  EXPECT_NEAR(std::abs(contact.normal.dot(R.col(2))), 1.0, 1e-14);
  EXPECT_NEAR(contact.depth, 0.02, 1e-15);
}

TEST(Contact, OfAllButCoincidentCentresIsFinite) {
  test::Random random(61);
  for (const double distance : {1e-6, 1e-12, 1e-100, 1e-155, 1e-160, 1e-162, 1e-200, 5e-324}) {
    double worst_length = 0.0, farthest = 0.0, least_depth = 1.0, most_depth = 0.0;
    for (int i = 0; i < 60; ++i) {
      const double thickness = i % 3 == 0 ? 0.01 : i % 3 == 1 ? 1e-7 : 0.0;
      const Ellipsoid tool = Ellipsoid::from_semi_axes({{0, 0, 0}, random.rotation()}, {0.02, 0.02, 0.04});
      const Ellipsoid gaussian = Ellipsoid::from_semi_axes({distance * random.direction(), random.rotation()},
                                                           {0.02, 0.01, thickness});
      const Contact contact = contact_of(tool, gaussian);
      ASSERT_TRUE(contact.point.allFinite() && contact.normal.allFinite()) << distance;
      worst_length = std::max(worst_length, std::abs(contact.normal.norm() - 1.0));
      farthest = std::max(farthest, contact.point.norm());
      least_depth = std::min(least_depth, contact.depth);
      most_depth = std::max(most_depth, contact.depth);
    }
    EXPECT_LE(worst_length, 1e-12) << distance;
    EXPECT_LE(farthest, 4.0 * distance) << distance;  // twice the tool's longest over its shortest axis
    EXPECT_GE(least_depth, 0.02) << distance;
    EXPECT_LE(most_depth, 0.06) << distance;
  }
}

TEST(ContactInvariance, RigidMotionTurnsItAlong) {
  test::Random random(62);
  for (int i = 0; i < 300; ++i) {
    const Pair pair = random_pair(random, random.uniform(0.01, 0.95));
    const Eigen::Matrix3d R = random.rotation().toRotationMatrix();
    const Eigen::Vector3d t = random.in_box(2.0);
    const auto moved = [&](const Ellipsoid& e) -> Ellipsoid { return {R * e.center + t, R * e.axes}; };
    const Contact before = contact_of(pair.tool, pair.gaussian);
    const Contact after = contact_of(moved(pair.tool), moved(pair.gaussian));
    EXPECT_LE((after.normal - R * before.normal).norm(), 1e-7);
    EXPECT_LE((after.point - (R * before.point + t)).norm(), 1e-8);
    EXPECT_NEAR(after.depth, before.depth, 1e-9);
  }
}

TEST(ContactInvariance, ScaleScalesIt) {
  test::Random random(63);
  for (int i = 0; i < 300; ++i) {
    const Pair pair = random_pair(random, random.uniform(0.01, 0.95));
    const double s = std::ldexp(1.0, random.integer(-20, 20));
    const auto scaled = [&](const Ellipsoid& e) -> Ellipsoid { return {s * e.center, s * e.axes}; };
    const Contact before = contact_of(pair.tool, pair.gaussian);
    const Contact after = contact_of(scaled(pair.tool), scaled(pair.gaussian));
    EXPECT_LE((after.normal - before.normal).norm(), 1e-15);
    EXPECT_LE((after.point - s * before.point).norm(), 1e-15 * s);
    EXPECT_NEAR(after.depth, s * before.depth, 1e-15 * s);
  }
}

TEST(ContactInvariance, SwappingTheSolidsTurnsTheNormalRound) {
  test::Random random(64);
  for (int i = 0; i < 300; ++i) {
    const Pair pair = random_pair(random, random.uniform(0.01, 0.95));
    const Contact one = contact_of(pair.tool, pair.gaussian);
    const Contact other = contact_of(pair.gaussian, pair.tool);
    EXPECT_LE((one.normal + other.normal).norm(), 1e-7);
    EXPECT_LE((one.point - other.point).norm(), 1e-8);
    EXPECT_NEAR(one.depth, other.depth, 1e-9);
    EXPECT_NEAR(one.lambda, 1.0 - other.lambda, 1e-7);
  }
}

TEST(ContactSet, KMaxIsTheLargestAndZeroWithoutContact) {
  ContactSet set;
  EXPECT_EQ(set.k_max(), 0.0);
  for (const double k : {0.25, 0.75, 0.5}) {
    Contact& c = set.contacts.emplace_back();
    c.k_min = k;
  }
  set.candidates = 9;
  set.filtered = 5;
  EXPECT_EQ(set.k_max(), 0.75);
  set.clear();
  EXPECT_TRUE(set.contacts.empty());
  EXPECT_EQ(set.candidates + set.filtered, 0U);
  EXPECT_EQ(set.k_max(), 0.0);
}

// Eq. 4. Spheres that just touch are kept, so that rounding cannot take a contact away.
TEST(SpheresOverlap, IsEquationFourAndKeepsWhatTouches) {
  EXPECT_TRUE(spheres_overlap(ball({0, 0, 0}, 1), 1.0, ball({0, 2.9, 0}, 2), 2.0));
  EXPECT_FALSE(spheres_overlap(ball({0, 0, 0}, 1), 1.0, ball({0, 3.000001, 0}, 2), 2.0));
  EXPECT_FALSE(spheres_overlap(ball({0, 0, 0}, 1), 1.0, ball({2, 2, 2}, 2), 2.0));  // 3.46 apart
  test::Random random(65);
  for (int i = 0; i < 10000; ++i) {
    const double a = random.log_uniform(1e-6, 1e3), b = random.log_uniform(1e-6, 1e3);
    const Ellipsoid one = ball({0, 0, 0}, a), other = ball((a + b) * random.direction(), b);
    EXPECT_TRUE(spheres_overlap(one, a, other, b))
        << "spheres that touch, up to the rounding of a unit vector";
  }
}

}  // namespace
}  // namespace palpate

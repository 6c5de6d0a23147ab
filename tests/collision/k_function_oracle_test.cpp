// K_min against 113-bit arithmetic (support/k_oracle.h): hard cases by name, and 100,000 random pairs.
//
// Two bars. `kBar` is what k_function.h promises. Where a size ratio r makes d' or L as large as r tool
// radii while the contact is decided within one, the doubles that describe the pair cannot hold that:
// turning an axis by one unit in the last place moves K by r times as much. There the error bound of the
// method applies instead, |dK| <= 2 l (sqrt(f) |dd'| + f |dL|) with dd' and dL a few units in the last
// place of the products that make d' and L, and so the test still fails if a single digit is lost.

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/k_function.h>
#include <support/k_oracle.h>
#include <support/parallel.h>
#include <support/random_pairs.h>
#include <support/solids.h>

namespace palpate {
namespace {

using test::exact_ellipsoid;
using test::LiteralPaper;
using test::moved_to_k_min;
using test::oracle_minimum;
using test::OracleMinimum;
using test::Pair;
using test::PairOracle;
using test::Quad;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// |dK_min| allowed, relative to max(1, 1 - K_min).
constexpr double kBar = 1e-12;

/// Largest errors seen over many pairs.
struct Worst {
  double k = 0.0;         ///< |dK_min| / max(1, 1 - K_min)
  double k_bound = 0.0;   ///< |dK_min| over the error bound of the pair's own conditioning
  double log_t = 0.0;     ///< |d ln t| times the curvature of ln(1-K) in ln t; |d lambda| at an end
  double lambda = 0.0;    ///< how far lambda and log_t are from saying the same
  int wrong_verdict = 0;  ///< sign of K_min differs although |K_min| is beyond the bar

  void merge(const Worst& other) {
    k = std::max(k, other.k);
    k_bound = std::max(k_bound, other.k_bound);
    log_t = std::max(log_t, other.log_t);
    lambda = std::max(lambda, other.lambda);
    wrong_verdict += other.wrong_verdict;
  }
};

/// Largest |row of W| |row-wise products| that make up d' and L, in tool radii.
double magnitude(const WhitenedTool& tool, const Eigen::Matrix3d& m) {
  return (tool.W.cwiseAbs() * m.cwiseAbs()).norm();
}

/// The error bound of this pair if every operation that makes d' and L is off by a few units.
double conditioned_bar(const Pair& pair, const OracleMinimum<Quad>& truth) {
  constexpr double kUnits = 8.0;
  const WhitenedTool tool(pair.tool);
  Eigen::Matrix3d d = Eigen::Matrix3d::Zero();
  d.col(0) = pair.tool.center - pair.gaussian.center;
  const double f = std::max(0.0, static_cast<double>(1 - truth.k_min));
  const double lambda = static_cast<double>(truth.lambda());
  return kUnits * kEpsilon *
         (1.0 + f +
          2.0 * lambda * (std::sqrt(f) * magnitude(tool, d) + f * magnitude(tool, pair.gaussian.axes)));
}

/// Second derivative of ln(1-K) in ln t, by differences.
double curvature(const PairOracle<Quad>& oracle, Quad t) {
  const Quad h = 1e-7;
  const Quad before = 1 - oracle.k_at_t(t * (1 - h)), at = 1 - oracle.k_at_t(t),
             after = 1 - oracle.k_at_t(t * (1 + h));
  return std::abs(static_cast<double>((before - 2 * at + after) / (h * h * at)));
}

Worst compare(const Pair& pair, bool with_lambda) {
  const OracleMinimum<Quad> truth = oracle_minimum(pair.tool, pair.gaussian);
  const KMinimum found = minimize(KFunction(WhitenedTool(pair.tool), pair.gaussian));
  EXPECT_TRUE(std::isfinite(found.k_min) && std::isfinite(found.lambda) && std::isfinite(found.log_t));
  const double error = std::abs(static_cast<double>(found.k_min - truth.k_min));
  const double scale = std::max(1.0, static_cast<double>(1 - truth.k_min));
  const double bar = conditioned_bar(pair, truth);
  Worst worst;
  worst.k = error / scale;
  worst.k_bound = error / bar;
  const auto k_true = static_cast<double>(truth.k_min);
  if (std::abs(k_true) > std::max(kBar, bar) && (k_true > 0.0) != (found.k_min > 0.0))
    worst.wrong_verdict = 1;
  if (!with_lambda) return worst;
  if (truth.t > 1e-30 && truth.t < 1e30) {
    const double c = curvature(PairOracle<Quad>(pair.tool, pair.gaussian), truth.t);
    worst.log_t = c * std::abs(found.log_t - std::log(static_cast<double>(truth.t)));
  } else {
    worst.log_t = std::abs(found.lambda - static_cast<double>(truth.lambda()));
  }
  worst.lambda = std::abs(found.lambda - 1.0 / (1.0 + std::exp(-found.log_t)));
  return worst;
}

using Generator = std::function<Pair(test::Random&)>;

/// K_min that the pairs are moved to: mostly near tangency, the rest anything.
double random_k_min(test::Random& random) {
  switch (random.integer(0, 5)) {
    case 0: return 0.0;
    case 1: return random.uniform(-1e-12, 1e-12);
    case 2: return random.uniform(-1e-9, 1e-9);
    case 3: return random.uniform(-1e-6, 1e-6);
    case 4: return random.uniform(-1.0, 1.0);
    default: return 1.0 - random.log_uniform(1e-12, 1e6);
  }
}

Worst worst_of(const Generator& generate, std::size_t count, std::uint64_t seed) {
  std::vector<Worst> parts(test::kThreads);
  test::on_threads([&](std::size_t thread) {
    for (std::size_t i = thread; i < count; i += test::kThreads) {
      test::Random random(seed * 1'000'003 + i);
      Pair pair = generate(random);
      pair.gaussian = moved_to_k_min(pair.tool, pair.gaussian, random_k_min(random));
      constexpr std::size_t kEvery = 8;  // curvature() costs as much as the rest
      parts[thread].merge(compare(pair, i / test::kThreads % kEvery == 0));
    }
  });
  Worst worst;
  for (const Worst& part : parts) worst.merge(part);
  return worst;
}

const Eigen::Vector3d kOrigin = Eigen::Vector3d::Zero();
const Eigen::Vector3d kTool(0.02, 0.02, 0.04);  // the default tool [m]

Ellipsoid turned(test::Random& random, const Eigen::Vector3d& center, const Eigen::Vector3d& semi_axes) {
  return Ellipsoid::from_semi_axes({center, random.rotation()}, semi_axes);
}

/// The pair with its Gaussian put where a random point of its surface is near one of the tool's, so that
/// contacts on the rim of a disc and on the side of a needle are as likely as on the face and the tip.
Pair touching(test::Random& random, const Ellipsoid& tool, Ellipsoid gaussian) {
  const Eigen::Vector3d on_gaussian = gaussian.axes * random.direction();
  const Eigen::Vector3d on_tool = tool.axes * random.direction();
  gaussian.center = tool.center - on_gaussian - on_tool;
  return {tool, gaussian};
}

/// The default tool and a Gaussian of these semi-axes.
Generator gaussian_of(const Eigen::Vector3d& semi_axes) {
  return [=](test::Random& r) {
    const Ellipsoid tool = turned(r, r.in_box(1.0), kTool);
    return touching(r, tool, turned(r, kOrigin, semi_axes));
  };
}

/// Solids of about these sizes, moderately anisotropic.
Generator sizes_of(double tool, double gaussian) {
  return [=](test::Random& r) {
    const Eigen::Vector3d center = r.in_box(1.0), semi_axes = tool * r.semi_axes(0.3, 1.0);
    const Ellipsoid placed = turned(r, center, semi_axes);
    return touching(r, placed, turned(r, kOrigin, gaussian * r.semi_axes(0.3, 1.0)));
  };
}

/// A tool and a Gaussian of these semi-axes. Tool axes that are orthogonal only up to rounding
/// describe another tool, by rounding times the ratio of its semi-axes: these are exact.
Generator tool_of(const Eigen::Vector3d& tool, const Eigen::Vector3d& gaussian) {
  return [=](test::Random& r) {
    const Ellipsoid placed = exact_ellipsoid(r, r.in_box(0.1), tool);
    return touching(r, placed, turned(r, kOrigin, gaussian));
  };
}

struct HardCase {
  std::string name;
  Generator generate;
  bool ill_conditioned = false;  ///< judged by conditioned_bar() alone
};

std::vector<HardCase> hard_cases() {
  const auto one_inside = [](double offset, double low, double high) -> Generator {
    return [=](test::Random& r) -> Pair {
      const Ellipsoid tool = turned(r, r.in_box(1.0), kTool);
      const Eigen::Vector3d center = tool.center + r.in_box(offset);
      return {tool, turned(r, center, r.semi_axes(low, high))};
    };
  };
  return {
      {"Balls", gaussian_of({0.01, 0.01, 0.01})},
      {"FlatSplat", gaussian_of({0.01, 0.006, 1e-5})},
      {"Needle", gaussian_of({0.3, 1e-6, 1e-7})},
      {"Disc", gaussian_of({0.05, 0.02, 0.0})},
      {"NeedleOfZeroThickness", gaussian_of({0.3, 0.0, 0.0})},
      {"Point", gaussian_of({0.0, 0.0, 0.0})},
      {"ThinnestDenormal", gaussian_of({0.01, 1e-200, 5e-324})},
      {"GaussianInsideTool", one_inside(0.002, 1e-4, 1e-3)},
      {"ToolInsideGaussian", one_inside(0.02, 0.5, 1.0)},
      {"GaussianLarger1e5", sizes_of(1e-2, 1e3)},
      {"ToolLarger1e5", sizes_of(1e3, 1e-2)},
      {"GaussianLarger1e8", sizes_of(1e-4, 1e4)},
      {"ToolLarger1e8", sizes_of(1e4, 1e-4)},
      {"FlatGaussianLarger1e5", gaussian_of({1e3, 1e3, 1e-5}), true},
      {"OneKilometreAway",
       [](test::Random& r) {
         const Ellipsoid tool = turned(r, 1e3 * r.direction(), kTool);
         return touching(r, tool, turned(r, kOrigin, {0.01, 0.006, 1e-5}));
       }},
      {"ToolAnisotropic", tool_of({0.3, 0.01, 1e-4}, {0.01, 0.006, 1e-4})},
      {"ToolDisc", tool_of({0.1, 0.1, 1e-6}, {0.01, 0.006, 1e-3})},
      {"ToolNeedle", tool_of({0.3, 1e-5, 1e-6}, {0.01, 0.006, 1e-3})},
      {"ToolDiscOfRoundedAxes",
       [](test::Random& r) {
         const Ellipsoid tool = turned(r, r.in_box(0.1), {0.1, 0.1, 1e-6});
         return touching(r, tool, turned(r, kOrigin, {0.01, 0.006, 1e-3}));
       },
       true},
      {"NeedleOnNeedle", tool_of({0.3, 1e-3, 1e-4}, {0.3, 1e-5, 1e-6})},
      {"DiscOnDisc", tool_of({0.1, 0.1, 1e-4}, {0.1, 0.1, 0.0})},
  };
}

void PrintTo(const HardCase& c, std::ostream* out) { *out << c.name; }

/// What a test prints and leaves in its XML output.
void report(const std::string& name, const Worst& worst) {
  testing::Test::RecordProperty("worst_dk", testing::PrintToString(worst.k));
  testing::Test::RecordProperty("worst_dk_over_bound", testing::PrintToString(worst.k_bound));
  std::printf("  %-24s |dK|/max(1,1-K) %.1e, over its bound %.2g, curvature * |d ln t| %.1e\n", name.c_str(),
              worst.k, worst.k_bound, worst.log_t);
}

void expect_exact(const Worst& worst, bool ill_conditioned) {
  if (!ill_conditioned) {
    EXPECT_LE(worst.k, kBar);
  }
  EXPECT_LE(worst.k_bound, 1.0);
  EXPECT_LE(worst.log_t, 1e-9);
  EXPECT_LE(worst.lambda, 2.0 * kEpsilon);
  EXPECT_EQ(worst.wrong_verdict, 0);
}

class KMinHardCase : public testing::TestWithParam<HardCase> {};

TEST_P(KMinHardCase, AgreesWithQuadruplePrecision) {
  const HardCase& c = GetParam();
  const Worst worst = worst_of(c.generate, 2000, 11);
  report(c.name, worst);
  expect_exact(worst, c.ill_conditioned);
}

INSTANTIATE_TEST_SUITE_P(Named, KMinHardCase, testing::ValuesIn(hard_cases()),
                         [](const auto& info) { return info.param.name; });

TEST(KMin, AgreesWithQuadruplePrecisionOnRandomPairs) {
  const Worst worst = worst_of(
      [](test::Random& r) {
        const Ellipsoid tool = r.ellipsoid(1.0, 0.01, 0.1);
        return touching(r, tool, turned(r, kOrigin, r.semi_axes(1e-6, 0.3)));
      },
      100'000, 12);
  report("Random", worst);
  expect_exact(worst, false);
}

// Where K has a long plateau beyond its minimum, the slope there is rounding noise, and a search that
// believes its sign settles on the plateau: 0.2 above the minimum, with the other verdict.
TEST(KMin, IsNotHeldUpByAPlateau) {
  Pair pair;
  pair.tool.axes << 0.024218750360887498, 0.087500001303851604, -0.00043750002078013495,  //
      -0.087500001303851604, -0.00078125001164153218, -0.00050000002374872565,            //
      -0.043750000651925802, 0.05000000074505806, 0.00075781253599416232;
  pair.gaussian.axes << -0.028597368932709057, -0.094381409843202368, 0.0,  //
      -0.015541669230399076, 0.021624614820704813, 0.0,                     //
      0.094554994620376337, -0.024990508395501307, 0.0;
  pair.gaussian.center << -0.13436023134139224, -0.050801338261993081, 0.0011129279266696949;
  EXPECT_NEAR(minimize(KFunction(WhitenedTool(pair.tool), pair.gaussian)).k_min, -0.0211093187964593, 1e-12);

  const Worst worst = worst_of(tool_of({0.1, 0.01, 0.003}, {0.1, 0.02, 0.0}), 20'000, 13);
  report("Plateau", worst);
  expect_exact(worst, false);
}

TEST(KMin, IsOneWhereCentresCoincide) {
  test::Random random(14);
  for (const Eigen::Vector3d& semi_axes :
       {Eigen::Vector3d(0.3, 1e-6, 1e-7), Eigen::Vector3d(0.05, 0.02, 0.0), Eigen::Vector3d(0.3, 0.0, 0.0),
        Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(1e5, 1e5, 1e5)}) {
    const Eigen::Vector3d center = random.in_box(1e3);
    const WhitenedTool tool(turned(random, center, kTool));
    const KMinimum found = minimize(KFunction(tool, turned(random, center, semi_axes)));
    EXPECT_EQ(found.k_min, 1.0);
    EXPECT_EQ(found.lambda, 0.5);
    EXPECT_EQ(found.log_t, 0.0);
  }
}

TEST(KMin, IsJustBelowOneWhereCentresAllButCoincide) {
  test::Random random(15);
  for (const double distance : {1e-6, 1e-9, 1e-15, 1e-100, 1e-160, 1e-163, 1e-200, 5e-324}) {
    for (const double thickness : {0.01, 1e-7, 0.0}) {
      const Ellipsoid tool = turned(random, Eigen::Vector3d::Zero(), kTool);
      const Ellipsoid gaussian = turned(random, distance * random.direction(), {0.02, 0.01, thickness});
      const KMinimum found = minimize(KFunction(WhitenedTool(tool), gaussian));
      EXPECT_NEAR(found.k_min, static_cast<double>(oracle_minimum(tool, gaussian).k_min), kBar) << distance;
      EXPECT_TRUE(found.lambda >= 0.0 && found.lambda <= 1.0) << distance;
      EXPECT_TRUE(std::isfinite(found.log_t)) << distance;
    }
  }
}

// The header: log_t is at the end of its range if the minimum is at lambda = 1. What that is for: a
// Gaussian much smaller than the tool, of which only 1/t counts, must not be taken for a solid one.
TEST(KMin, LogTTellsAMinimumAtOne) {
  test::Random random(16);
  const Ellipsoid tool = turned(random, Eigen::Vector3d::Zero(), kTool);
  const Ellipsoid point = turned(random, random.in_box(0.01), Eigen::Vector3d::Zero());
  const KMinimum at_point = minimize(KFunction(WhitenedTool(tool), point));
  EXPECT_EQ(at_point.lambda, 1.0);
  EXPECT_GT(at_point.log_t, 100.0);
  // A ball on the middle of a disc, from slightly off its axis.
  const Ellipsoid ball{{0.001, 0.002, 0.01}, 0.02 * Eigen::Matrix3d::Identity()};
  const Ellipsoid disc{{0.0, 0.0, 0.0}, Eigen::Vector3d(0.03, 0.03, 0.0).asDiagonal()};
  const KMinimum at_disc = minimize(KFunction(WhitenedTool(ball), disc));
  EXPECT_NEAR(at_disc.k_min, 0.75, 1e-15);  // 1 - (0.01 / 0.02)^2
  EXPECT_EQ(at_disc.lambda, 1.0);
  EXPECT_GT(at_disc.log_t, 100.0);
}

// The references themselves.

TEST(KOracle, AgreesWithTheLiteralPaper) {
  test::Random random(17);
  double worst = 0.0;
  for (int i = 0; i < 300; ++i) {
    const Ellipsoid tool = random.ellipsoid(0.1, 0.01, 0.1);
    const Ellipsoid gaussian = random.ellipsoid(0.1, 0.001, 0.1);
    const PairOracle<Quad> oracle(tool, gaussian);
    const LiteralPaper paper(tool, gaussian);
    const OracleMinimum<Quad> minimum = oracle_minimum(tool, gaussian);
    for (const Quad lambda : {Quad(0.125), Quad(0.5), Quad(0.9), minimum.lambda()}) {
      const Quad k = paper.k(lambda);
      worst = std::max(worst, std::abs(static_cast<double>((oracle.k_at_lambda(lambda) - k) / (1 - k))));
      EXPECT_GE(static_cast<double>(k - minimum.k_min), -1e-24);
    }
    const test::Vec3<Quad> m = paper.m(minimum.lambda());
    EXPECT_LE(static_cast<double>(test::norm(m - minimum.point)), 1e-24);
  }
  EXPECT_LE(worst, 1e-22);  // the literal form loses the rest to (0.1 / 0.001)^2 and to w^T m - ...
}

TEST(KOracle, FastSearchAgreesWithBisectionInQuadAlone) {
  test::Random random(18);
  for (const HardCase& c : hard_cases()) {
    for (int i = 0; i < 20; ++i) {
      Pair pair = c.generate(random);
      pair.gaussian = moved_to_k_min(pair.tool, pair.gaussian, random_k_min(random));
      const OracleMinimum<Quad> fast = oracle_minimum(pair.tool, pair.gaussian);
      const OracleMinimum<Quad> slow = PairOracle<Quad>(pair.tool, pair.gaussian).minimize();
      EXPECT_LE(std::abs(static_cast<double>((fast.k_min - slow.k_min) / (1 - slow.k_min))), 1e-18) << c.name;
      // No K nearby is less, whatever the slope says.
      const PairOracle<Quad> oracle(pair.tool, pair.gaussian);
      for (const double factor : {0.5, 0.999, 1.001, 2.0}) {
        const Quad k = oracle.k_at_t(slow.t * Quad(factor));
        EXPECT_GE(static_cast<double>((k - slow.k_min) / (1 - slow.k_min)), -1e-20) << c.name;
      }
    }
  }
}

TEST(KOracle, LongDoubleDoesForRealScenes) {
  test::Random random(19);
  double worst = 0.0;
  for (int i = 0; i < 2000; ++i) {
    Pair pair = gaussian_of({0.03, 0.003, 5e-7})(random);
    pair.gaussian = moved_to_k_min(pair.tool, pair.gaussian, random_k_min(random));
    const auto quad = oracle_minimum(pair.tool, pair.gaussian).k_min;
    const auto fast = PairOracle<long double>(pair.tool, pair.gaussian).minimize().k_min;
    worst = std::max(
        worst, std::abs(static_cast<double>(quad - fast)) / std::max(1.0, static_cast<double>(1 - quad)));
    const PairOracle<long double> oracle(pair.tool, pair.gaussian);
    EXPECT_EQ(oracle.k_min(1e-3L) < 1e-3L, quad < 1e-3);
    worst = std::max(worst, std::abs(static_cast<double>(quad - oracle.k_min(-1e30L))) /
                                std::max(1.0, static_cast<double>(1 - quad)));
  }
  EXPECT_LE(worst, 1e-16);
}

}  // namespace
}  // namespace palpate

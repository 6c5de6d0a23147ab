#include <palpate/study/touch_path.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <palpate/base/error.h>
#include <palpate/collision/scene_index.h>
#include <palpate/haptics/tool_query.h>
#include <palpate/study/procedural.h>
#include <palpate/study/still_life.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

/// A scene for touch_path(), which looks at the ellipsoids, with the query over it.
struct Touchable {
  explicit Touchable(const GaussianScene& scene, double scale = 1.0) : index(scene, {}, similarity(scale)) {
    FilterReport report;
    kept = filter_scene(scene, {}, similarity(scale), report);
  }
  static Similarity similarity(double scale) {
    Similarity world_from_scene;
    world_from_scene.scale = scale;
    return world_from_scene;
  }

  EllipsoidScene kept;
  SceneIndex index;
};

GaussianScene scene_of(const std::string& shape) { return make_scene(*make_surface(shape), {}); }

/// A stretch of poses at which the tool meets a surface: [begin, end).
struct Episode {
  std::size_t begin;
  std::size_t end;
};

std::vector<std::size_t> contact_counts(const ContactQuery& query, const Tool& tool, const Trajectory& path) {
  std::vector<std::size_t> counts;
  ContactSet found;
  for (const TimedPose& timed : path) {
    palpate::query(query, tool, timed.pose, found);
    counts.push_back(found.contacts.size());
  }
  return counts;
}

std::vector<Episode> episodes(const std::vector<std::size_t>& counts) {
  std::vector<Episode> found;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] < kSolidContacts) continue;
    if (found.empty() || found.back().end != i) found.push_back({i, i});
    found.back().end = i + 1;
  }
  return found;
}

Vector3d axis(const Pose& pose) { return pose.orientation * Vector3d::UnitZ(); }

/// Least distance of the tool's boundary to the surface, by samples 2 deg apart.
double gap(const AnalyticSurface& surface, const Tool& tool, const Pose& pose) {
  Random random(1);
  std::vector<SurfaceSample> ball;
  make_sphere(1.0)->sample(0.035, random, ball);
  double least = std::numeric_limits<double>::infinity();
  for (const SurfaceSample& s : ball) {
    const Vector3d p = pose.position + pose.orientation * s.point.cwiseProduct(tool.parts()[0].semi_axes);
    least = std::min(least, surface.distance(p));
  }
  return least;
}

/// A path over a scene, and what it meets.
struct Exploration {
  explicit Exploration(const std::string& shape) : surface(make_surface(shape)) {}

  std::unique_ptr<AnalyticSurface> surface;
  Touchable scene{make_scene(*surface, {})};
  const SceneIndex& index = scene.index;
  Tool tool;
  TouchPathOptions options;
  Trajectory path = touch_path(index, scene.kept, tool, options);
  std::vector<std::size_t> counts = contact_counts(index, tool, path);
  std::vector<Episode> found = episodes(counts);
};

/// Made once for all tests of a shape.
const Exploration& exploration_of(const std::string& shape) {
  static std::map<std::string, Exploration> made;
  return made.try_emplace(shape, shape).first->second;
}

class TouchPathOn : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override { ASSERT_EQ(found.size(), 7U); }

  const Exploration& exploration = exploration_of(GetParam());
  const AnalyticSurface& surface = *exploration.surface;
  const SceneIndex& index = exploration.index;
  const Tool& tool = exploration.tool;
  const TouchPathOptions& options = exploration.options;
  const Trajectory& path = exploration.path;
  const std::vector<std::size_t>& counts = exploration.counts;
  const std::vector<Episode>& found = exploration.found;
};

INSTANTIATE_TEST_SUITE_P(Procedural, TouchPathOn, testing::Values("sphere", "table", "shell", "torus"),
                         [](const auto& shape) { return std::string(shape.param); });

TEST_P(TouchPathOn, IsSampledAtTheRate) {
  for (std::size_t i = 0; i < path.size(); ++i) ASSERT_EQ(path[i].t, static_cast<double>(i) / options.rate);
}

TEST_P(TouchPathOn, TouchesDistinctPlacesInReasonableTime) {
  for (std::size_t a = 0; a < found.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const Vector3d way = path[found[a].begin].pose.position - path[found[b].begin].pose.position;
      EXPECT_GT(way.norm(), tool.thinnest());
    }
  }
  EXPECT_GT(path.back().t, 12.0);
  EXPECT_LT(path.back().t, 60.0);
}

TEST_P(TouchPathOn, FirstContactIsAtTheTrueSurface) {
  for (const Episode& episode : found)
    EXPECT_NEAR(gap(surface, tool, path[episode.begin].pose), 0.0, 0.5 * surface.default_spacing());
}

TEST_P(TouchPathOn, PressesInAlongTheToolByTheDepthAskedFor) {
  for (const Episode& episode : found) {
    const Pose& first = path[episode.begin].pose;
    double depth = 0.0;
    for (std::size_t i = episode.begin; i < episode.end; ++i) {
      const Vector3d way = path[i].pose.position - first.position;
      const double along = way.dot(axis(first));
      if ((way - along * axis(first)).norm() > 1e-9) break;  // the slide begins
      depth = std::max(depth, along);
    }
    EXPECT_NEAR(depth, options.press, 3e-4);  // the first pose in contact is up to 0.2 mm below contact
  }
}

TEST_P(TouchPathOn, SlidesAtConstantDepthBelowFirstContact) {
  constexpr double kTolerance = 5e-4;  // between two slide steps, 2 mm apart, the surface is interpolated
  ContactSet contacts;
  for (const Episode& episode : found) {
    const Pose& first = path[episode.begin].pose;
    double length = 0.0;
    for (std::size_t i = episode.begin; i < episode.end; i += 10) {
      const Vector3d way = path[i].pose.position - first.position;
      const double lateral = (way - way.dot(axis(first)) * axis(first)).norm();
      if (lateral < length + 1e-9) continue;  // not sliding
      length = lateral;
      const auto solid_at = [&](double depth) {
        Pose pose = path[i].pose;
        pose.position += (depth - options.press) * axis(first);
        query(index, tool, pose, contacts);
        return contacts.contacts.size() >= kSolidContacts;
      };
      ASSERT_TRUE(solid_at(kTolerance)) << lateral;
      ASSERT_FALSE(solid_at(-kTolerance)) << lateral;
    }
    EXPECT_GT(length, 0.6 * options.slide);
    EXPECT_LT(length, options.slide + 1e-9);
  }
}

TEST_P(TouchPathOn, PointsTheToolAlongTheApproachAndHoldsItThere) {
  for (const Episode& episode : found) {
    const Pose& first = path[episode.begin].pose;
    const Vector3d motion = path[episode.begin + 20].pose.position - first.position;
    EXPECT_GT(motion.normalized().dot(axis(first)), 1.0 - 1e-9);
    for (std::size_t i = episode.begin; i < episode.end; ++i)
      ASSERT_LT(path[i].pose.orientation.angularDistance(first.orientation), 1e-7);
  }
}

TEST_P(TouchPathOn, TravelsWithoutContact) {
  constexpr std::size_t kGrazing = 40;  // poses at which the tool meets fewer than kSolidContacts
  std::vector<bool> near(path.size(), false);
  for (const Episode& episode : found) {
    const std::size_t end = std::min(path.size(), episode.end + kGrazing);
    for (std::size_t i = episode.begin - std::min(kGrazing, episode.begin); i < end; ++i) near[i] = true;
  }
  for (std::size_t i = 0; i < path.size(); ++i) ASSERT_TRUE(near[i] || counts[i] == 0) << path[i].t;
}

TEST_P(TouchPathOn, MovesAsAHandDoes) {
  constexpr double kDifferences = 1.01;  // of what is sampled
  Vector3d before = Vector3d::Zero();
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Vector3d velocity = (path[i].pose.position - path[i - 1].pose.position) * options.rate;
    ASSERT_LE(velocity.norm(), kDifferences * options.speed) << path[i].t;
    ASSERT_LE((velocity - before).norm() * options.rate, kDifferences * options.acceleration) << path[i].t;
    before = velocity;
    ASSERT_NEAR(path[i].pose.orientation.norm(), 1.0, 1e-9);
    ASSERT_LT(path[i].pose.orientation.angularDistance(path[i - 1].pose.orientation), 0.01) << path[i].t;
  }
  EXPECT_LT(before.norm() * options.rate, options.acceleration) << "ends at rest";
}

// As large as palpate setup proposes it: a slide there follows what bends more sharply than the shapes above
// do.
TEST(TouchPathOnStillLife, SlidesNoFasterThanAHandFollows) {
  const Touchable still_life(make_still_life().scene, 1.9);
  const TouchPathOptions options;
  const Trajectory path = touch_path(still_life.index, still_life.kept, Tool(), options);
  double most = 0.0;
  for (std::size_t i = 2; i < path.size(); ++i) {
    const Vector3d second =
        path[i].pose.position - 2.0 * path[i - 1].pose.position + path[i - 2].pose.position;
    most = std::max(most, second.norm() * options.rate * options.rate);
  }
  EXPECT_LE(most, 1.01 * options.acceleration);
}

// The bench of the still life is two thin layers, of which a small tool meets fewer Gaussians than make a
// surface.
TEST(TouchPathOnStillLife, PassesNothingOnItsWay) {
  const Touchable still_life(make_still_life().scene, 1.9);
  const Tool small(Vector3d::Constant(0.008));
  for (const std::uint64_t seed : {5U, 23U}) {
    const Trajectory path = touch_path(still_life.index, still_life.kept, small, {.seed = seed});
    const std::vector<std::size_t> counts = contact_counts(still_life.index, small, path);
    const std::vector<Episode> found = episodes(counts);
    const auto is_near = [&](std::size_t i) {
      return std::ranges::any_of(found, [&](const Episode& episode) {
        const auto way = [&](std::size_t k) {
          return (path[i].pose.position - path[k].pose.position).norm();
        };
        return (episode.begin <= i && i < episode.end) ||
               std::min(way(episode.begin), way(episode.end)) < 2.0 * small.thinnest();
      });
    };
    for (std::size_t i = 0; i < path.size(); ++i) ASSERT_TRUE(counts[i] == 0 || is_near(i)) << path[i].t;
  }
}

bool same(const Trajectory& a, const Trajectory& b) {
  return std::ranges::equal(a, b, [](const TimedPose& p, const TimedPose& q) {
    return p.t == q.t && p.pose.position == q.pose.position &&
           p.pose.orientation.coeffs() == q.pose.orientation.coeffs();
  });
}

struct TouchPath : testing::Test {
  GaussianScene sphere = scene_of("sphere");
  Touchable touchable{sphere};
  const EllipsoidScene& scene = touchable.kept;
  const SceneIndex& index = touchable.index;
  Tool tool;

  std::size_t touched(const Trajectory& path) const {
    return episodes(contact_counts(index, tool, path)).size();
  }
};

TEST_F(TouchPath, SameSeedSamePath) {
  const Trajectory path = touch_path(index, scene, tool, {});
  EXPECT_TRUE(same(path, touch_path(index, scene, tool, {})));
  EXPECT_FALSE(same(path, touch_path(index, scene, tool, {.seed = 2})));
}

TEST_F(TouchPath, TouchesAsOftenAsAsked) {
  for (const int touches : {1, 2, 12}) {
    const Trajectory path = touch_path(index, scene, tool, {.touches = touches, .rate = 200.0});
    EXPECT_EQ(touched(path), static_cast<std::size_t>(touches));
  }
}

TEST_F(TouchPath, ScalesWithSceneAndTool) {
  constexpr double kScale = 64.0;  // a power of two is exact
  const Touchable large_scene(sphere, kScale);
  const Tool large_tool(kScale * tool.parts()[0].semi_axes);
  const Trajectory small = touch_path(index, scene, tool, {});
  const Trajectory large = touch_path(
      large_scene.index, large_scene.kept, large_tool,
      {.press = kScale * 0.005, .slide = kScale * 0.05, .speed = kScale * 0.5, .acceleration = kScale * 5.0});
  ASSERT_EQ(small.size(), large.size());
  for (std::size_t i = 0; i < small.size(); ++i)
    ASSERT_LT((kScale * small[i].pose.position - large[i].pose.position).norm(), kScale * 1e-4);
}

TEST_F(TouchPath, NamesTheWayToAScaleForASceneThatIsTooLarge) {
  constexpr double kScale = 1e4;
  const Touchable street(sphere, kScale);
  try {
    touch_path(street.index, street.kept, Tool(kScale * tool.parts()[0].semi_axes), {});
    FAIL() << "a hand that takes hours";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("--scale"));
  }
}

TEST_F(TouchPath, WithoutPressAndSlideOnlyTouches) {
  for (const TouchPathOptions& options : {TouchPathOptions{.press = 0.0}, TouchPathOptions{.slide = 0.0}}) {
    const Trajectory path = touch_path(index, scene, tool, options);
    ASSERT_FALSE(path.empty());
    for (const TimedPose& timed : path) ASSERT_TRUE(timed.pose.position.allFinite());
  }
  EXPECT_EQ(touched(touch_path(index, scene, tool, {.slide = 0.0})), 7U);
}

TEST_F(TouchPath, FloatersAndAGiantAreNotASurface) {
  GaussianScene dirty = sphere;
  Random random(5);
  const auto add = [&](const Vector3d& center, double radius) {
    dirty.id.push_back(static_cast<std::uint32_t>(dirty.id.size()));
    dirty.position.push_back(center.cast<float>());
    dirty.scale.push_back(Eigen::Vector3f::Constant(static_cast<float>(std::log(radius))));
    dirty.rotation.emplace_back(1.0F, 0.0F, 0.0F, 0.0F);
    dirty.opacity.push_back(2.0F);
    dirty.color.push_back({0, 0, 0});
  };
  ASSERT_EQ(dirty.scale_encoding, ScaleEncoding::kLog);
  for (int k = 0; k < 20; ++k) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    add(0.3 * Vector3d(x, y, z), 0.004);
  }
  add({0.1, 0.0, 0.0}, 1.0);  // fog around everything
  const Touchable dirty_scene(dirty);
  EXPECT_EQ(touched(touch_path(dirty_scene.index, dirty_scene.kept, tool, {})), 7U);
}

TEST(TouchPathOnPlane, StopsSlidingAtTheEdge) {
  const Touchable plane(scene_of("plane"));
  const Tool tool;
  const Trajectory path = touch_path(plane.index, plane.kept, tool, {.slide = 1.0});
  const auto counts = contact_counts(plane.index, tool, path);
  ASSERT_EQ(episodes(counts).size(), 7U);
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (counts[i] < kSolidContacts) continue;
    ASSERT_LT(path[i].pose.position.head<2>().cwiseAbs().maxCoeff(), 0.2 + 0.02);
  }
}

TEST_F(TouchPath, ImpossibleRequestsAreRefused) {
  const Touchable nothing{GaussianScene{}};
  EXPECT_THROW(touch_path(nothing.index, nothing.kept, tool, {}), Error);
  EXPECT_THROW(touch_path(index, scene, Tool(Vector3d::Constant(0.0005)), {}), Error)
      << "slips between the splats";
  EXPECT_THROW(touch_path(index, scene, Tool({0.02, 0.0, 0.02}), {}), Error);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(touch_path(index, scene, tool, {.touches = 0}), Error);
  EXPECT_THROW(touch_path(index, scene, tool, {.touches = 1'000'000}), Error);
  for (const double bad : {-1.0, kNan}) {
    EXPECT_THROW(touch_path(index, scene, tool, {.press = bad}), Error);
    EXPECT_THROW(touch_path(index, scene, tool, {.slide = bad}), Error);
    EXPECT_THROW(touch_path(index, scene, tool, {.rate = bad}), Error);
  }
  EXPECT_THROW(touch_path(index, scene, tool, {.rate = 0.0}), Error);
  EXPECT_THROW(touch_path(index, scene, tool, {.speed = 0.0}), Error);
  EXPECT_THROW(touch_path(index, scene, tool, {.acceleration = 0.0}), Error);
  EXPECT_THROW(touch_path(index, scene, tool, {.rate = 1e12}), Error);
}

}  // namespace
}  // namespace palpate

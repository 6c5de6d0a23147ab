#include <palpate/study/still_life.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <palpate/base/error.h>
#include <palpate/collision/scene_index.h>
#include <palpate/haptics/proxy_force.h>
#include <palpate/study/solid_noise.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;

constexpr double kCoarse = 0.006;  // where the fine structure does not matter. Unit: [m].

/// As it is built in; made once.
const StillLife& built_in() {
  static const StillLife made = make_still_life();
  return made;
}

/// Of all positions, rounded to 10 um so that the last bit of a sine does not matter, and all colours
/// (FNV-1a).
std::uint64_t fingerprint(const GaussianScene& scene) {
  std::uint64_t hash = 14695981039346656037U;
  const auto add = [&](std::int64_t value) {
    hash = (hash ^ static_cast<std::uint64_t>(value)) * 1099511628211U;
  };
  for (std::size_t i = 0; i < scene.size(); ++i) {
    for (const float x : scene.position[i]) add(std::llround(1e5 * static_cast<double>(x)));
    for (const std::uint8_t c : scene.color[i]) add(c);
  }
  return hash;
}

/// The first object of each name.
std::map<std::string, StillLifeObject> by_name(const StillLife& still_life) {
  std::map<std::string, StillLifeObject> objects;
  for (const StillLifeObject& object : still_life.objects) objects.emplace(object.name, object);
  return objects;
}

TEST(StillLife, HasEnoughGaussiansAndEveryOneIsOfOneObject) {
  const StillLife& made = built_in();
  EXPECT_GE(made.scene.size(), 200'000U);
  EXPECT_LE(made.scene.size(), 400'000U);
  std::uint32_t next = 0;
  std::set<std::string> names;
  for (const StillLifeObject& object : made.objects) {
    EXPECT_EQ(object.ids.first, next) << object.name;
    EXPECT_GT(object.ids.last, object.ids.first + 50) << object.name;
    next = object.ids.last + 1;
    names.insert(object.name);
  }
  EXPECT_EQ(next, made.scene.size());
  EXPECT_THAT(names, testing::UnorderedElementsAre("table", "cloth", "bowl", "log", "plate", "stone",
                                                   "orange", "apple", "grape", "pear", "lemon"));
}

TEST(StillLife, EveryGaussianCanCollideAndIsSeen) {
  const GaussianScene& scene = built_in().scene;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    ASSERT_EQ(defect(scene, i), Defect::kNone) << i;
    const Gaussian g = scene.gaussian(i);
    ASSERT_GT(g.opacity, 0.5) << i;
    ASSERT_LT(g.sigma.maxCoeff(), 0.01) << i;
    ASSERT_LT(g.position.cwiseAbs().maxCoeff(), 0.46) << i;
  }
}

TEST(StillLife, IsTheSameForTheSameSeedAndOnEveryCompiler) {
  const std::uint64_t coarse = fingerprint(make_still_life(1, kCoarse).scene);
  EXPECT_EQ(fingerprint(make_still_life(1, kCoarse).scene), coarse);
  EXPECT_NE(fingerprint(make_still_life(2, kCoarse).scene), coarse);
  EXPECT_EQ(coarse, 16556228111232323108U)
      << "a change of the scene changes this; of the compiler, it must not";
}

TEST(StillLife, SurfacesAreWithinTheirReliefOfTheirShapes) {
  const StillLife& made = built_in();
  std::set<std::string> shaped;
  for (const StillLifeObject& object : made.objects) {
    if (!object.shape) continue;
    shaped.insert(object.name);
    EXPECT_LT(object.relief, 0.02);
    for (std::uint32_t i = object.ids.first; i <= object.ids.last; ++i) {
      const Vector3d p = made.scene.gaussian(i).position - object.pose.position;
      const double off = object.shape->nearest(object.pose.orientation.conjugate() * p).distance;
      ASSERT_LE(std::abs(off), object.relief + 1e-6) << object.name << " " << i;
    }
  }
  EXPECT_THAT(shaped, AllOf(testing::Contains("orange"), testing::Contains("log"), testing::Contains("plate"),
                            testing::Contains("grape"), testing::Contains("table")));
}

TEST(StillLife, MaterialsAreByObject) {
  const StillLife& made = built_in();
  const MaterialMap materials(material_regions(made));
  const PlyMaterials columns = material_columns(made);
  const MaterialMap from_file({}, columns);
  for (const StillLifeObject& object : made.objects) {
    for (const std::uint32_t id : {object.ids.first, object.ids.last}) {
      EXPECT_EQ(materials.of(id, Vector3d::Zero()), object.material) << object.name;
      const Material written = from_file.of(id, Vector3d::Zero());
      EXPECT_NEAR(written.friction.value(), object.material.friction.value(), 1e-6) << object.name;
      EXPECT_NEAR(written.stiffness.value(), object.material.stiffness.value(), 1e-3) << object.name;
      EXPECT_EQ(written.damping.has_value(), object.material.damping.has_value()) << object.name;
    }
  }
  auto of = by_name(made);
  EXPECT_GT(of["log"].material.friction, of["cloth"].material.friction);
  EXPECT_GT(of["cloth"].material.friction, of["table"].material.friction);
  EXPECT_GT(of["table"].material.friction, of["plate"].material.friction);
  EXPECT_GT(of["stone"].material.stiffness, of["apple"].material.stiffness);
  EXPECT_GT(of["apple"].material.stiffness, of["grape"].material.stiffness);
}

/// Its Gaussian that is highest, and so free from above unless something lies on it.
std::size_t highest(const StillLife& made, const StillLifeObject& object) {
  std::size_t best = object.ids.first;
  for (std::size_t i = object.ids.first; i <= object.ids.last; ++i) {
    if (made.scene.position[i].z() > made.scene.position[best].z()) best = i;
  }
  return best;
}

TEST(StillLife, AFingerOnEachThingFeelsIt) {
  constexpr double kFinger = 0.008;  // radius. Unit: [m].
  constexpr double kPressed = 0.002;
  const StillLife& made = built_in();
  const SceneIndex index(made.scene, SceneFilter{}, Similarity{});
  ProxyParameters parameters;
  parameters.materials = std::make_shared<MaterialMap>(material_regions(made));
  const Tool finger(Vector3d::Constant(kFinger));
  ContactSet none;
  std::set<std::string> felt;
  for (const StillLifeObject& object : made.objects) {
    // One of each name will do: a grape may have another on it, which a push from above meets first.
    ProxyForce force(index, finger, parameters);
    const Vector3d top = made.scene.gaussian(highest(made, object)).position;
    ForceInput input;
    input.dt = 1e-3;
    input.contacts = &none;
    ForceOutput output;
    for (double above = 0.02; above > -kPressed; above -= 0.0005) {
      input.tool.position = top + Vector3d(0, 0, kFinger + above);
      output = force.evaluate(input);
    }
    if (output.wrench.force.z() > 0.05) felt.insert(object.name);
  }
  EXPECT_EQ(felt.size(), by_name(made).size()) << testing::PrintToString(felt);
}

TEST(StillLife, RefusesASpacingThatIsNone) {
  for (const double spacing : {0.0, -1.0, 0.0001, 1.0, std::nan("")})
    EXPECT_THAT(test::message_of<Error>([&] { make_still_life(1, spacing); }),
                HasSubstr("must be 0.001 m to 0.02 m for a still life"));
}

TEST(SolidNoise, IsBoundedContinuousAndByItsSeed) {
  double most = 0.0, apart = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const Vector3d p(0.37 * k, -0.21 * k, 0.11 * k + 3.0);
    for (const double n : {solid_noise(p, 7), fractal_noise(p, 4, 7), ridged_noise(p, 3, 7)}) {
      ASSERT_LE(std::abs(n), 1.0);
      most = std::max(most, std::abs(n));
    }
    apart = std::max(apart, std::abs(solid_noise(p, 7) - solid_noise(p, 8)));
    ASSERT_NEAR(solid_noise(p, 7), solid_noise(p + Vector3d(1e-7, -1e-7, 1e-7), 7), 2e-6);
  }
  EXPECT_GT(most, 0.8);
  EXPECT_GT(apart, 0.8);
}

}  // namespace
}  // namespace palpate

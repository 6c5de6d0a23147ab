// The frame of a scene that moves as a whole.

#include <vector>

#include <gtest/gtest.h>

#include <palpate/haptics/anchored_scene.h>
#include <support/random_scenes.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

SceneIndex sphere_scene(std::uint64_t seed, const Similarity& world_from_scene) {
  test::Random random(seed);
  return {test::scene_of(test::sphere_of_splats(random, 200)), SceneFilter{}, world_from_scene};
}

Similarity somewhere(test::Random& random, double scale, bool mirrored = false) {
  return {scale, random.rotation(), random.in_box(3.0), mirrored};
}

/// The index in A, with A where it is, is the index.
void expect_in_place(const AnchoredScene& anchored, const SceneIndex& index, test::Random& random) {
  for (int k = 0; k < 20; ++k) {
    const Vector3d x_S = random.in_box(2.0);
    const Vector3d x_A = anchored.scene().world_from_scene() * x_S;
    const Pose& X_WA = anchored.X_WA();
    EXPECT_LE((X_WA.orientation * x_A + X_WA.position - index.world_from_scene() * x_S).norm(), 1e-12);
  }
}

TEST(AnchoredScene, MovesWithTheSameGaussiansAndKeepsTheirIndex) {
  test::Random random(1);
  for (const bool mirrored : {false, true}) {
    SceneIndex index = sphere_scene(2, somewhere(random, 0.3, mirrored));
    const SceneIndex first = index;
    AnchoredScene anchored(index);
    const SceneIndex* address = &anchored.scene();
    EXPECT_TRUE(anchored.follow());
    EXPECT_FALSE(anchored.has_moved());
    for (int k = 0; k < 50; ++k) {
      index = index.registered(somewhere(random, 0.3, mirrored));
      ASSERT_TRUE(anchored.follow());
      EXPECT_TRUE(anchored.has_moved());
      EXPECT_EQ(anchored.scene().epoch(), first.epoch()) << "what is known of it stays true";
      EXPECT_EQ(&anchored.scene(), address);
      expect_in_place(anchored, index, random);
    }
    // Composed poses bring rounding into the scale.
    index = index.registered(somewhere(random, 0.3 * (1.0 + 1e-14), mirrored));
    EXPECT_TRUE(anchored.follow());
    index = first;
    EXPECT_TRUE(anchored.follow());
    EXPECT_FALSE(anchored.has_moved()) << "the world frame again, to the last bit";
  }
}

TEST(AnchoredScene, StaysWhereItIsWithWhatIsNotTheSame) {
  test::Random random(3);
  SceneIndex index = sphere_scene(4, somewhere(random, 0.3));
  AnchoredScene anchored(index);
  for (const bool has_moved : {false, true}) {
    if (has_moved) {
      index = index.registered(somewhere(random, 0.3));
      ASSERT_TRUE(anchored.follow());
    }
    const Pose before = anchored.X_WA();
    const std::vector<SceneIndex> others{
        index.registered(somewhere(random, 0.3001)),                           // another scale
        index.registered(somewhere(random, 0.3001, true)),                     // a mirror image
        sphere_scene(5, somewhere(random, 0.3001)),                            // other Gaussians
        SceneIndex(sphere_scene(4, {})).registered(index.world_from_scene()),  // in other memory
        sphere_scene(4, somewhere(random, 0.3)),
        index.registered(somewhere(random, 0.3))};
    for (const SceneIndex& other : others) {
      const std::uint64_t known = anchored.scene().epoch();
      index = other;
      EXPECT_FALSE(anchored.follow());
      EXPECT_TRUE(anchored.follow()) << "once";
      EXPECT_NE(anchored.scene().epoch(), known);
      EXPECT_TRUE(anchored.scene().shares_memory_with(index));
      EXPECT_EQ(anchored.X_WA(), before);
      expect_in_place(anchored, index, random);
    }
  }
}

}  // namespace
}  // namespace palpate

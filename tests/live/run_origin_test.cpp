// The provenance of a run, read back from its file.
#include <palpate/live/run_origin.h>

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/csv.h>
#include <palpate/base/error.h>
#include <palpate/base/version.h>
#include <palpate/live/provenance.h>

#include <support/live_scene.h>
#include <support/temporary_file.h>

namespace palpate::test {
namespace {

using testing::HasSubstr;
using enum ConfigGroup;

constexpr const char* kRows = "t,x,y,z\n0,0,0,0.1\n";

/// A run on plane(), with a setting, and a trajectory that the run itself replaces.
TemporaryFile run_on_plane() {
  LiveConfig config = plane_config();
  config.force.proxy.stiffness = 123.0;
  config.device.trajectory = "hand.csv";
  const Provenance known = provenance("run", scene_origin(config.scene), config, {kScene, kForce, kDevice});
  return TemporaryFile(csv_comment(to_toml(known)) + kRows, "run.csv");
}

std::vector<std::string> values_of(const std::vector<ConfigEntry>& entries, const std::string& key) {
  std::vector<std::string> values;
  for (const ConfigEntry& entry : entries)
    if (entry.key == key) values.push_back(entry.value);
  return values;
}

TEST(RunOrigin, HasTheSettingsWithoutTheSceneAndTheRunAsTrajectory) {
  const TemporaryFile run = run_on_plane();
  EXPECT_TRUE(has_provenance(run.path()));
  const RunOrigin origin(run.path());
  EXPECT_EQ(origin.version(), version());
  const auto entries = origin.entries();
  EXPECT_THAT(values_of(entries, "stiffness"), testing::ElementsAre("123"));
  EXPECT_THAT(values_of(entries, "trajectory"), testing::ElementsAre(run.path()));
  EXPECT_THAT(values_of(entries, "scene"), testing::IsEmpty());
}

TEST(RunOrigin, IsNothingWithoutAHeader) {
  const TemporaryFile bare(kRows, "bare.csv");
  EXPECT_FALSE(has_provenance(bare.path()));
  EXPECT_THAT(message_of<Error>([&] { const RunOrigin none(bare.path()); }),
              HasSubstr("has no record of how it was made"));
}

TEST(RunOrigin, GivesItsSceneAndRefusesAnother) {
  const TemporaryFile run = run_on_plane();
  const RunOrigin origin(run.path());
  LiveConfig none;
  origin.settle(none);
  EXPECT_EQ(none.scene.path, plane());
  origin.check(plane_config().scene);

  const TemporaryFile sphere(ply_bytes(make_scene(*make_surface("sphere"), {}), "sphere"), "sphere.ply");
  LiveConfig other = plane_config();
  other.scene.path = sphere.path();
  EXPECT_THAT(message_of<Error>([&] { origin.settle(other); }), HasSubstr("was made with another scene"));
  EXPECT_THAT(message_of<Error>([&] { origin.check(other.scene); }),
              HasSubstr("was made with another scene"));
}

}  // namespace
}  // namespace palpate::test

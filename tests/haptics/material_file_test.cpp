#include <string>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/haptics/material_file.h>
#include <support/file_mistake.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using test::FileMistake;
using test::message_of;
using test::TemporaryFile;
using testing::AllOf;
using testing::HasSubstr;

std::vector<MaterialRegion> regions_of(const std::string& text) {
  return read_materials(TemporaryFile(text, "m.toml").path());
}

TEST(MaterialFile, ReadsEveryShapeAndProperty) {
  const auto regions = regions_of(
      "[[region]]\nstiffness = 500\n"
      "[[region]]\nname = 'rubber mat'\nbox = { min = [0, -1, 0.5], max = [1, 1, 0.5] }\nfriction = 0.6\n"
      "[[region]]\nsphere = { center = [1, 2, 3], radius = 0.25 }\ndamping = 2.0\nstiffness = 1e6\n"
      "[[region]]\nids = [7, 3, [100, 200], [4, 4]]\nfriction = 0\n");
  ASSERT_EQ(regions.size(), 4U);
  EXPECT_TRUE(std::holds_alternative<MaterialRegion::Everywhere>(regions[0].shape));
  EXPECT_EQ(regions[0].material, (Material{500.0, {}, {}}));
  const auto& box = std::get<AlignedBox3d>(regions[1].shape);
  EXPECT_EQ(box.min(), Vector3d(0, -1, 0.5));
  EXPECT_EQ(box.max(), Vector3d(1, 1, 0.5));
  EXPECT_EQ(regions[1].material, (Material{{}, 0.6, {}}));
  const auto& sphere = std::get<MaterialSphere>(regions[2].shape);
  EXPECT_EQ(sphere.center, Vector3d(1, 2, 3));
  EXPECT_EQ(sphere.radius, 0.25);
  EXPECT_EQ(regions[2].material, (Material{1e6, {}, 2.0}));
  EXPECT_EQ(std::get<IdSet>(regions[3].shape).ranges(), (std::vector<IdRange>{{3, 4}, {7, 7}, {100, 200}}));
  EXPECT_EQ(regions[3].material, (Material{{}, 0.0, {}}));
}

TEST(MaterialFile, TakesLongListsOfIds) {
  std::string text = "[[region]]\nfriction = 1\nids = [";
  for (int k = 0; k < 100000; ++k) text += fmt::format("[{},{}],", 10 * k, 10 * k + 5);
  const auto regions = regions_of(text + "]\n");
  EXPECT_EQ(std::get<IdSet>(regions[0].shape).ranges().size(), 100000U);
}

TEST(MaterialFile, NamesEveryMistake) {
  for (const auto& [text, line, words] : std::vector<FileMistake>{
           {"[[region]]\nstiffness = -1", 2, "'stiffness' must be a number from 0 to 1000000, not -1"},
           {"[[region]]\nstiffness = 1.1e6", 2, "'stiffness'"},
           {"[[region]]\nfriction = 11", 2, "'friction' must be a number from 0 to 10"},
           {"[[region]]\ndamping = 10001", 2, "'damping' must be a number from 0 to 10000"},
           {"[[region]]\nfriction = nan", 2, "'friction'"},
           {"[[region]]\nfriction = 'high'", 2, "not 'high'"},
           {"\n[[region]]\nname = 'mat'", 2, "changes nothing"},
           {"[[region]]\nname = 5\nfriction = 1", 2, "'name' must be text"},
           {"[[region]]\nfrictoin = 1", 2,
            "unknown key 'frictoin'; the known keys are name, box, sphere, ids, "},
           {"friction = 1", 1, "unknown key 'friction'; the known keys are region"},
           {"[region]\nfriction = 1", 1, "[[region]]"},
           {"[[region]]\nfriction = 1\nids = [1]\nbox = {min = [0, 0, 0], max = [1, 1, 1]}", 1, "one shape"},
           {"[[region]]\nfriction = 1\nbox = {min = [0, 0, 0]}", 3, "'max' is missing"},
           {"[[region]]\nfriction = 1\nbox = {min = [0, 0, 0], max = [1, -1, 1]}", 3, "above"},
           {"[[region]]\nfriction = 1\nbox = {min = [0, 0], max = [1, 1, 1]}", 3, "an array of 3 numbers"},
           {"[[region]]\nfriction = 1\nbox = {min = [0, 0, 0], max = [1, 1, 1], mid = 1}", 3, "'mid'"},
           {"[[region]]\nfriction = 1\nbox = [0, 0, 0, 1, 1, 1]", 3, "'box' must be a table"},
           {"[[region]]\nfriction = 1\nsphere = {center = [0, 0, 0], radius = -1}", 3, "'radius'"},
           {"[[region]]\nfriction = 1\nsphere = {center = [0, 0, inf], radius = 1}", 3, "'center'"},
           {"[[region]]\nfriction = 1\nsphere = {center = [0, 0, 0], r = 1}", 3, "'radius' is missing"},
           {"[[region]]\nfriction = 1\nids = []", 3, "'ids' must be ids"},
           {"[[region]]\nfriction = 1\nids = 5", 3, "'ids' must be an array"},
           {"[[region]]\nfriction = 1\nids = [1,\n-2]", 4,
            "'ids' must be a whole number from 0 to 4294967295"},
           {"[[region]]\nfriction = 1\nids = [4294967296]", 3, "4294967295"},
           {"[[region]]\nfriction = 1\nids = [1.5]", 3, "a whole number"},
           {"[[region]]\nfriction = 1\nids = [[1, 2, 3]]", 3, "[first, last]"},
           {"[[region]]\nfriction = 1\nids = [[5, 4]]", 3, "[5, 4] ends before it begins"},
           {"[[region]]\nfriction = 1\nids = [[[1], 2]]", 3, "a whole number"},
       }) {
    EXPECT_THAT(message_of<Error>([text = text] { regions_of(text); }),
                AllOf(HasSubstr("m.toml: line " + std::to_string(line) + ": "), HasSubstr(words)))
        << text;
  }
}

TEST(MaterialFile, RefusesTooFewAndTooManyRegions) {
  EXPECT_THAT(message_of<Error>([] { regions_of("# nothing\n"); }), HasSubstr("no [[region]]"));
  std::string text;
  for (std::size_t k = 0; k < kMaxMaterialRegions; ++k) text += "[[region]]\nfriction = 1\n";
  EXPECT_EQ(regions_of(text).size(), kMaxMaterialRegions);
  EXPECT_THAT(message_of<Error>([&] { regions_of(text + "[[region]]\nfriction = 1\n"); }),
              HasSubstr("257 regions, more than 256"));
}

}  // namespace
}  // namespace palpate

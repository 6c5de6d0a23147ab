// Figures of opening a scene: where its index came from, and sizes.
#include <palpate/study/open_timing.h>

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/scene/ply_writer.h>
#include <palpate/study/procedural.h>

#include <support/temporary_file.h>

namespace palpate::test {
namespace {

TEST(TimeOpening, SaysWhereTheIndexCameFrom) {
  const GaussianScene scene = make_scene(*make_surface("plane"), {});
  const TemporaryFile file(ply_bytes(scene, "plane"), "plane.ply");
  const auto open = [&](IndexFiles files) { return time_opening(file.path(), {}, {}, files); };
  EXPECT_EQ(open(IndexFiles::kNone).figures.origin, "memory");
  EXPECT_FALSE(std::filesystem::exists(index_path(file.path())));
  EXPECT_EQ(open(IndexFiles::kUse).figures.origin, "new index file");
  const TimedIndex again = open(IndexFiles::kUse);
  EXPECT_EQ(again.figures.origin, "index file");
  EXPECT_THAT(again.figures.remarks, testing::IsEmpty());
  EXPECT_GT(again.figures.seconds, 0.0);
  EXPECT_EQ(again.figures.gaussians, again.index.size());
  EXPECT_EQ(again.figures.index_bytes, again.index.bytes());
}

TEST(TimeOpening, RemarksOnAnIndexFileThatCannotBeUsed) {
  const TemporaryFile file(ply_bytes(make_scene(*make_surface("plane"), {}), "plane"), "plane.ply");
  std::ofstream(index_path(file.path())) << "no index";
  const TimedIndex timed = time_opening(file.path(), {}, {}, IndexFiles::kUse);
  EXPECT_EQ(timed.figures.origin, "new index file");
  EXPECT_EQ(timed.figures.remarks.size(), 1U);
}

TEST(MeasureSizes, AreThoseOfTheFileAndOfThisProcess) {
  const TemporaryFile file("12345", "scene");
  OpenFigures figures;
  measure_sizes(file.path(), figures);
  EXPECT_EQ(figures.scene_bytes, 5U);
  EXPECT_GT(figures.peak_bytes, 1'000'000U);  // a program with these libraries
}

}  // namespace
}  // namespace palpate::test

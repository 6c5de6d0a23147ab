// From a scene file to an index: by the file beside the scene where that fits, and never worse than without.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <palpate/base/error.h>
#include <palpate/collision/index_builder.h>
#include <palpate/collision/index_file.h>
#include <palpate/collision/open_index.h>
#include <support/indexed_scene.h>
#include <support/random_pairs.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

namespace fs = std::filesystem;
using test::message_of;
using test::ReadOnly;
using test::SceneFile;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using Origin = OpenedIndex::Origin;

class OpenIndex : public testing::Test {
 protected:
  /// Opens the index of the scene and expects it to come from `origin`, and to be right.
  OpenedIndex open(Origin origin, const SceneFilter& filter = {}, const Similarity& world = {},
                   IndexFiles files = IndexFiles::kUse) const {
    OpenedIndex opened = open_index(scene_.path(), filter, world, files);
    EXPECT_EQ(static_cast<int>(opened.origin), static_cast<int>(origin));
    FilterReport report;
    filter_scene(scene_.scene(), filter, world, report);
    EXPECT_EQ(opened.report, report);
    EXPECT_EQ(opened.index.size(), report.kept);
    scene_.expect_same_contacts(opened.index, SceneIndex(scene_.scene(), filter, world));
    return opened;
  }
  /// True if the index file is whole and of `filter`.
  bool fits(const SceneFilter& filter) const {
    try {
      IndexFile(index_, scene_.path(), index_options(filter, {}));
      return true;
    } catch (const Error&) {
      return false;
    }
  }
  std::string index_bytes() const {
    std::ifstream in(index_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  SceneFile scene_;
  std::string index_ = index_path(scene_.path());
};

TEST_F(OpenIndex, IsBesideTheScene) {
  EXPECT_EQ(index_path("a/garden.ply"), "a/garden.ply.palpate");
  EXPECT_EQ(index_path("a/garden.splat"), "a/garden.splat.palpate");
}

TEST_F(OpenIndex, MakesAFileAndThenUsesIt) {
  const OpenedIndex made = open(Origin::kNewFile);
  EXPECT_FALSE(made.rejected || made.not_written);
  EXPECT_THAT(scene_.files(), ElementsAre("garden.ply", "garden.ply.palpate"));
  const std::string bytes = index_bytes();
  const auto written = fs::last_write_time(index_);
  const OpenedIndex used = open(Origin::kFile);
  EXPECT_FALSE(used.rejected || used.not_written);
  EXPECT_EQ(fs::last_write_time(index_), written);
  EXPECT_TRUE(index_bytes() == bytes);
}

TEST_F(OpenIndex, WithoutFilesNeitherReadsNorWritesOne) {
  const OpenedIndex alone = open(Origin::kMemory, {}, {}, IndexFiles::kNone);
  EXPECT_FALSE(alone.rejected || alone.not_written);
  EXPECT_THAT(scene_.files(), ElementsAre("garden.ply"));
  std::ofstream(index_) << "not a palpate index";
  EXPECT_FALSE(open(Origin::kMemory, {}, {}, IndexFiles::kNone).rejected);
  EXPECT_EQ(index_bytes(), "not a palpate index");
}

TEST_F(OpenIndex, IsTheSameWhereverTheSceneIsPut) {
  open(Origin::kNewFile);
  // The tools touch the unit sphere, so these keep it in place: a turn, and a turn the other way round.
  const Similarity turned{1.0, Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), {0, 0, 0}};
  open(Origin::kFile, {}, turned);
  const Similarity larger{1.02, Eigen::Quaterniond(0.5, -0.7, 0.1, 0.3).normalized(), {0.01, 0, 0}};
  open(Origin::kFile, {}, larger);
}

TEST_F(OpenIndex, WithOtherOptionsIsMadeAgain) {
  open(Origin::kNewFile);
  SceneFilter filter;
  filter.sigma = 2.0;
  EXPECT_THAT(*open(Origin::kNewFile, filter).rejected, AllOf(HasSubstr(index_), HasSubstr("other options")));
  EXPECT_FALSE(open(Origin::kFile, filter).rejected);
  filter.crop_sphere = SceneFilter::Sphere{{0, 0, 0}, 1.0};
  EXPECT_TRUE(open(Origin::kNewFile, filter).rejected);
  const Similarity moved{1.0, Eigen::Quaterniond::Identity(), {0.001, 0, 0}};
  EXPECT_TRUE(open(Origin::kNewFile, filter, moved).rejected) << "the crop is in the world";
  EXPECT_FALSE(open(Origin::kFile, filter, moved).rejected);
  filter = {};
  filter.iso = 0.2;
  EXPECT_TRUE(open(Origin::kNewFile, filter).rejected);
  EXPECT_FALSE(open(Origin::kFile, filter).rejected);
}

TEST_F(OpenIndex, OfASceneThatChangedIsMadeAgain) {
  open(Origin::kNewFile);
  scene_.write(2000, 801);  // of another size
  EXPECT_THAT(*open(Origin::kNewFile).rejected, AllOf(HasSubstr(index_), HasSubstr("stale")));
  const FileStamp stamp = stamp_of(scene_.path());
  scene_.write(2000, 802);  // of the same size, and made to look as old
  scene_.touch(stamp.modified_ns);
  EXPECT_EQ(stamp_of(scene_.path()).size, stamp.size);
  EXPECT_THAT(*open(Origin::kNewFile).rejected, HasSubstr("stale"));
  EXPECT_FALSE(open(Origin::kFile).rejected);
}

TEST_F(OpenIndex, KnowsTheHashOfItsSceneAsLongAsThatStaysAsItIs) {
  const std::uint64_t hash = content_hash(scene_.path());
  EXPECT_EQ(scene_hash(scene_.path()), hash) << "no index yet";
  open(Origin::kNewFile);
  ASSERT_TRUE(index_source(index_));
  EXPECT_EQ(index_source(index_)->content, hash);
  EXPECT_EQ(scene_hash(scene_.path()), hash);
  std::ofstream(scene_.path(), std::ios::app) << '\n';
  EXPECT_EQ(scene_hash(scene_.path()), content_hash(scene_.path()));
  EXPECT_NE(scene_hash(scene_.path()), hash);
  std::ofstream(index_, std::ios::trunc) << "no index";
  EXPECT_FALSE(index_source(index_));
  EXPECT_THROW(scene_hash(scene_.path() + ".no"), Error);
}

TEST_F(OpenIndex, OfASceneThatWasOnlyTouchedIsKept) {
  open(Origin::kNewFile);
  scene_.touch(1'234'567'890'000'000'000);
  EXPECT_FALSE(open(Origin::kFile).rejected);
}

TEST_F(OpenIndex, ThatIsDamagedIsMadeAgain) {
  open(Origin::kNewFile);
  const std::string sound = index_bytes();
  std::string flipped = sound;
  flipped[flipped.size() / 2] = static_cast<char>(flipped[flipped.size() / 2] ^ 4);
  for (const std::string& damaged :
       {std::string(), std::string("x"), sound.substr(0, sound.size() / 2), flipped}) {
    std::ofstream(index_, std::ios::binary | std::ios::trunc) << damaged;
    EXPECT_THAT(*open(Origin::kNewFile).rejected, HasSubstr(index_));
    EXPECT_TRUE(index_bytes() == sound);
    EXPECT_FALSE(open(Origin::kFile).rejected);
  }
}

TEST_F(OpenIndex, InAReadOnlyFolderIsInMemory) {
  {
    const ReadOnly read_only(scene_.folder());
    const OpenedIndex opened = open(Origin::kMemory);
    EXPECT_FALSE(opened.rejected);
    EXPECT_THAT(*opened.not_written, AllOf(HasSubstr(index_), HasSubstr("read-only")));
    EXPECT_FALSE(open(Origin::kMemory, {}, {}, IndexFiles::kNone).not_written);
  }
  EXPECT_THAT(scene_.files(), ElementsAre("garden.ply"));
  open(Origin::kNewFile);
  const ReadOnly read_only(scene_.folder());
  EXPECT_FALSE(open(Origin::kFile).not_written) << "one that is there can be used";
  SceneFilter filter;
  filter.sigma = 2.0;
  const OpenedIndex opened = open(Origin::kMemory, filter);
  EXPECT_TRUE(opened.rejected && opened.not_written);
}

// Nor is a FIFO waited for, neither for reading nor for writing.
TEST_F(OpenIndex, WhoseNameIsTakenByWhatIsNoFileIsInMemory) {
  const auto expect_in_memory = [&] {
    const OpenedIndex opened = open(Origin::kMemory);
    EXPECT_THAT(*opened.rejected, AllOf(HasSubstr(index_), HasSubstr("not a regular file")));
    EXPECT_THAT(*opened.not_written, AllOf(HasSubstr(index_), HasSubstr("not a regular file")));
  };
  fs::create_directory(index_);
  expect_in_memory();
  fs::remove(index_);
  ASSERT_EQ(::mkfifo(index_.c_str(), 0600), 0);
  expect_in_memory();
}

TEST_F(OpenIndex, OfABrokenSceneIsAnErrorAndLeavesNothing) {
  const std::string bytes = scene_.bytes();
  std::ofstream(scene_.path(), std::ios::binary | std::ios::trunc) << bytes.substr(0, bytes.size() - 5);
  EXPECT_THAT(message_of<Error>([&] { open_index(scene_.path(), {}, {}); }), HasSubstr(scene_.path()));
  EXPECT_THAT(scene_.files(), ElementsAre("garden.ply"));
  fs::remove(scene_.path());
  EXPECT_THAT(message_of<Error>([&] { open_index(scene_.path(), {}, {}); }),
              AllOf(HasSubstr(scene_.path()), HasSubstr("No such file")));
  EXPECT_TRUE(scene_.files().empty());
}

TEST_F(OpenIndex, OfASceneThatIsGoneIsAnErrorEvenIfItsIndexIsThere) {
  open(Origin::kNewFile);
  fs::remove(scene_.path());
  EXPECT_THAT(message_of<Error>([&] { open_index(scene_.path(), {}, {}); }), HasSubstr("No such file"));
}

TEST_F(OpenIndex, OfNothingKeptIsAnIndexToo) {
  SceneFilter filter;
  filter.opacity_min = 0.999;
  for (const Origin origin : {Origin::kNewFile, Origin::kFile}) {
    const OpenedIndex opened = open_index(scene_.path(), filter, {});
    EXPECT_EQ(static_cast<int>(opened.origin), static_cast<int>(origin));
    EXPECT_EQ(opened.index.size(), 0U);
    EXPECT_EQ(opened.report.low_opacity, scene_.scene().size());
    ContactSet set;
    opened.index.query(scene_.tools().front(), set);
    EXPECT_TRUE(set.contacts.empty());
  }
}

// What is beyond any size once it is in the world is a defect, so that here the index depends on the
// registration.
TEST(OpenIndexOfAGiantScene, IsMadeAgainWhereTheRegistrationOverflows) {
  const test::TemporaryFile file("", "far.ply");
  const std::vector<test::Splat> splats{test::splat({0, 0, 0}, {1, 1, 1}),
                                        test::splat({1e9, 0, 0}, {1, 1, 1})};
  write_ply(test::in_logarithms(test::scene_of(splats)), file.path(), "");
  Similarity large, far;
  large.scale = 1e6;
  far.translation = {1e12, 0, 0};
  EXPECT_EQ(open_index(file.path(), {}, {}).index.size(), 2U);
  EXPECT_EQ(open_index(file.path(), {}, large).index.size(), 1U);
  EXPECT_EQ(open_index(file.path(), {}, {}).index.size(), 2U);
  EXPECT_EQ(open_index(file.path(), {}, far).index.size(), 1U);
}

TEST_F(OpenIndex, StaysWholeWhileItsFileIsReplaced) {
  const OpenedIndex made = open(Origin::kNewFile), used = open(Origin::kFile);
  const SceneIndex reference(scene_.scene(), {}, {});
  SceneFilter filter;
  filter.sigma = 2.0;
  open_index(scene_.path(), filter, {});
  scene_.expect_same_contacts(made.index, reference);
  scene_.expect_same_contacts(used.index, reference);
  fs::remove(index_);
  scene_.expect_same_contacts(used.index, reference);
}

TEST_F(OpenIndex, ReportsProgressUpToOne) {
  std::vector<double> fractions;
  open_index(scene_.path(), {}, {}, IndexFiles::kUse, [&](std::string_view stage, double fraction) {
    if (stage == "indexing") fractions.push_back(fraction);
  });
  ASSERT_FALSE(fractions.empty());
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
}

/// What a process of its own finds with the first tool; 255 if anything is thrown.
int contacts_in_child(const SceneFile& scene, const SceneFilter& filter) {
  constexpr unsigned kSeconds = 120;
  ::alarm(kSeconds);
  try {
    const OpenedIndex opened = open_index(scene.path(), filter, {});
    ContactSet set;
    std::size_t count = 0;
    for (const Ellipsoid& tool : scene.tools()) {
      opened.index.query(tool, set);
      count += set.contacts.size();
    }
    return static_cast<int>(count % 251);
  } catch (const std::exception&) {
    return 255;
  }
}

// Four processes that find no index, or one with other options, all make one; whoever comes last stays.
TEST_F(OpenIndex, IsMadeByManyProcessesAtOnce) {
  std::vector<SceneFilter> filters(2);
  filters[1].sigma = 2.0;
  std::vector<int> expected;
  for (const SceneFilter& filter : filters) {
    const SceneIndex index(scene_.scene(), filter, {});
    ContactSet set;
    std::size_t count = 0;
    for (const Ellipsoid& tool : scene_.tools()) {
      index.query(tool, set);
      count += set.contacts.size();
    }
    expected.push_back(static_cast<int>(count % 251));
  }
  ASSERT_NE(expected[0], expected[1]);
  for (int round = 0; round < 10; ++round) {
    fs::remove(index_);
    std::vector<pid_t> children;
    for (std::size_t k = 0; k < 4; ++k) {
      const pid_t child = ::fork();
      ASSERT_GE(child, 0);
      if (child == 0) ::_exit(contacts_in_child(scene_, filters[round % 2 == 0 ? 0 : k % 2]));
      children.push_back(child);
    }
    for (std::size_t k = 0; k < children.size(); ++k) {
      int status = 0;
      ASSERT_EQ(::waitpid(children[k], &status, 0), children[k]);
      EXPECT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);
      EXPECT_EQ(WEXITSTATUS(status), expected[round % 2 == 0 ? 0 : k % 2]);
    }
    EXPECT_THAT(scene_.files(), ElementsAre("garden.ply", "garden.ply.palpate"));
    // Whole, and of one of the two.
    std::size_t fit = 0;
    for (const SceneFilter& filter : filters) fit += fits(filter);
    EXPECT_EQ(fit, 1U);
  }
}

/// A Gaussian as .splat has it.
struct SplatRecord {
  std::array<float, 3> position{}, sigma{};
  std::array<std::uint8_t, 4> color{}, rotation{};
};
static_assert(sizeof(SplatRecord) == 32);

/// Writes `record` as the one of this number; what was never written is zero, and a defect.
void put(int file, std::size_t number, const SplatRecord& record) {
  ASSERT_EQ(::pwrite(file, &record, sizeof record, static_cast<off_t>(number * sizeof record)), 32);
}

std::vector<Contact> touching(const SceneIndex& index, const Ellipsoid& tool) {
  ContactSet found;
  index.query(tool, found);
  std::ranges::sort(found.contacts, {}, &Contact::id);
  return found.contacts;
}

// More Gaussians than a tree may have, though few are kept: the scene is read twice and indexed in parts.
TEST(OpenIndexOfManyGaussians, IsTheOneOfThoseThatAreKept) {
  constexpr std::size_t kKept = 20'000, kEvery = 420;
  static_assert(kKept * kEvery > kMaxTreeRecords);
  const test::TemporaryFile few("", "few.splat"), many("", "many.splat");
  const int few_file = ::open(few.path().c_str(), O_WRONLY),
            many_file = ::open(many.path().c_str(), O_WRONLY);
  test::Random random(811);
  const auto place = [](std::size_t k) { return kEvery * k + 7; };
  for (std::size_t k = 0; k < kKept; ++k) {
    const Eigen::Vector3f at = random.direction().cast<float>();
    const SplatRecord record{
        {at.x(), at.y(), at.z()}, {0.01F, 0.01F, 0.002F}, {9, 9, 9, 230}, {200, 90, 128, 40}};
    put(few_file, k, record);
    put(many_file, place(k), record);
  }
  ASSERT_EQ(::ftruncate(many_file, static_cast<off_t>(kKept * kEvery * sizeof(SplatRecord))), 0);
  ::close(few_file);
  ::close(many_file);
  const SceneIndex expected = open_index(few.path(), {}, {}, IndexFiles::kNone).index;
  for (const auto& [files, origin] :
       {std::pair(IndexFiles::kNone, Origin::kMemory), std::pair(IndexFiles::kUse, Origin::kNewFile),
        std::pair(IndexFiles::kUse, Origin::kFile)}) {
    const OpenedIndex opened = open_index(many.path(), {}, {}, files);
    EXPECT_EQ(static_cast<int>(opened.origin), static_cast<int>(origin));
    EXPECT_EQ(opened.report.total, kKept * kEvery);
    EXPECT_EQ(opened.report.kept, kKept);
    EXPECT_EQ(opened.index.size(), kKept);
    std::size_t touched = 0;
    for (int n = 0; n < 50; ++n) {
      const Ellipsoid tool =
          Ellipsoid::from_semi_axes({random.direction(), random.rotation()}, {0.02, 0.05, 0.1});
      const std::vector<Contact> found = touching(opened.index, tool), truth = touching(expected, tool);
      ASSERT_EQ(found.size(), truth.size());
      for (std::size_t k = 0; k < found.size(); ++k) {
        EXPECT_EQ(found[k].id, place(truth[k].id));
        EXPECT_EQ(found[k].k_min, truth[k].k_min);
      }
      touched += found.size();
    }
    EXPECT_GT(touched, 500U);
  }
}

TEST_F(OpenIndex, RefusesWhatIsNoFilterOrRegistration) {
  const auto refusal = [&](const SceneFilter& filter, const Similarity& world) {
    return message_of<Error>([&] { open_index(scene_.path(), filter, world); });
  };
  for (const double none : {-1.0, 0.0, std::nan("")}) {
    SceneFilter filter;
    filter.sigma = none;
    EXPECT_THAT(refusal(filter, {}), HasSubstr("SceneFilter::sigma is"));
    Similarity world;
    world.scale = none;
    EXPECT_THAT(refusal({}, world), HasSubstr("Similarity::scale is"));
    world = {};
    world.rotation.w() = none == -1.0 ? 2.0 : none;
    EXPECT_THAT(refusal({}, world), HasSubstr("Similarity::rotation is not a unit quaternion"));
    filter = {};
    filter.iso = none;
    EXPECT_THAT(refusal(filter, {}), HasSubstr("SceneFilter::iso"));
    filter = {};
    filter.crop_sphere = SceneFilter::Sphere{Eigen::Vector3d::Zero(), none};
    EXPECT_THAT(refusal(filter, {}), HasSubstr("SceneFilter::crop_sphere"));
  }
  SceneFilter empty;
  empty.crop_box.emplace();
  EXPECT_THAT(refusal(empty, {}), HasSubstr("SceneFilter::crop_box"));
  EXPECT_FALSE(fs::exists(index_path(scene_.path())));
}

}  // namespace
}  // namespace palpate

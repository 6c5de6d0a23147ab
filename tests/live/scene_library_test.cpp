// What a page may open, and above all what it may not.
#include <palpate/live/scene_library.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <support/ply_builder.h>
#include <support/temporary_file.h>

namespace palpate::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

/// A folder with two scenes, one of them in a folder below, one of another format, and what is not a scene.
class SceneLibraryTest : public testing::Test {
 protected:
  SceneLibraryTest() {
    write("a.ply");
    write("below/b.splat");
    write("below/too/deep.ply");
    write("c.spz");
    write("notes.txt");
    std::ofstream(outside_.path()) << "ply";
    fs::create_symlink(outside_.path(), folder() / "link.ply");
    fs::create_symlink(folder() / "a.ply", folder() / "within.ply");
    fs::create_directory_symlink(outside_.folder(), folder() / "out");
  }
  void write(const std::string& name) const {
    fs::create_directories((folder() / name).parent_path());
    std::ofstream(folder() / name) << "ply";
  }
  fs::path folder() const { return file_.folder() / "scenes"; }

  TemporaryFile file_{"", "x"};
  TemporaryFile outside_{"", "secret.ply"};
};

std::vector<std::string> names(const SceneLibrary& library) {
  std::vector<std::string> result;
  for (const auto& entry : library.list()) result.push_back(entry.name);
  return result;
}

TEST_F(SceneLibraryTest, OffersTheScenesOfItsFoldersAndNoOtherFile) {
  const SceneLibrary library({folder().string()}, "/elsewhere/first.ply");
  EXPECT_THAT(names(library), testing::ElementsAre("The built-in still life", "first.ply", "a.ply",
                                                   "below/b.splat", "c.spz", "within.ply"));
  EXPECT_EQ(library.path_of("built-in"), "");
  EXPECT_EQ(library.path_of("first"), "/elsewhere/first.ply");
  EXPECT_EQ(library.path_of("0/below/b.splat"), fs::canonical(folder() / "below/b.splat").string());
}

TEST_F(SceneLibraryTest, OpensNothingThatIsNotOffered) {
  const SceneLibrary library({folder().string()}, "");
  for (const std::string id :
       {"", "first", "0/link.ply", "0/out/secret.ply", "0/../x", "0/notes.txt", "1/a.ply", "/etc/passwd",
        "0//etc/passwd", "0/below/../a.ply", "handed-over/a.ply"}) {
    EXPECT_THAT(message_of<Error>([&] { library.path_of(id); }), HasSubstr("there is no scene")) << id;
  }
  EXPECT_THAT(message_of<Error>([&] { library.path_of("0/c.spz"); }),
              AllOf(HasSubstr(".spz cannot be read"), HasSubstr("splat-transform")));
}

TEST_F(SceneLibraryTest, OpensAFileWhoseNameIsNotUtf8) {
  for (const char* name : {"caf\xe9.ply", "caf\xe8.ply", "caf\xc3\xa9.ply", "line\n.ply"})
    std::ofstream(folder() / name, std::ios::binary) << inria_file(1).bytes();
  const SceneLibrary library({folder().string()}, (folder() / "caf\xe9.ply").string());
  EXPECT_THAT(names(library),
              testing::IsSupersetOf({"caf%E9.ply", "caf%E8.ply", "caf\xc3\xa9.ply", "line%0A.ply"}));
  EXPECT_EQ(library.list()[1].name, "caf%E9.ply");
  EXPECT_EQ(library.path_of("0/caf%E9.ply"), fs::canonical(folder() / "caf\xe9.ply").string());
  EXPECT_EQ(library.path_of("0/caf%E8.ply"), fs::canonical(folder() / "caf\xe8.ply").string());
  EXPECT_EQ(library.path_of("0/caf\xc3\xa9.ply"), fs::canonical(folder() / "caf\xc3\xa9.ply").string());
}

TEST_F(SceneLibraryTest, SaysWhichPlyIsNoScene) {
  const auto write_bytes = [&](const std::string& name, const std::string& bytes) {
    std::ofstream(folder() / name, std::ios::binary) << bytes;
  };
  const std::string begin = "ply\nformat binary_little_endian 1.0\nelement vertex 1\n";
  write_bytes("good.ply", inria_file(1).bytes());
  write_bytes("packed.ply", begin + "property uint packed_position\nend_header\n....");
  write_bytes("mesh.ply",
              begin + "property float x\nproperty float y\nproperty float z\nend_header\n............");
  write_bytes("zip.ply", "PK\3\4....");
  const SceneLibrary library({folder().string()}, "");
  std::map<std::string, std::string> refusals;
  for (const auto& entry : library.list()) refusals[entry.name] = entry.refusal;
  EXPECT_EQ(refusals["good.ply"], "");
  EXPECT_THAT(refusals["packed.ply"], AllOf(StartsWith("is a compressed .ply"), HasSubstr("convert it")));
  EXPECT_THAT(refusals["mesh.ply"], HasSubstr("is not a Gaussian splatting scene"));
  EXPECT_THAT(refusals["zip.ply"], HasSubstr("is a zip file"));
  EXPECT_THAT(message_of<Error>([&] { library.path_of("0/packed.ply"); }), HasSubstr("compressed .ply"));
}

TEST_F(SceneLibraryTest, RefusesFoldersThatAreNone) {
  EXPECT_THAT(message_of<Error>([&] { SceneLibrary({"/nowhere/at/all"}, ""); }),
              HasSubstr("--scenes /nowhere/at/all"));
  EXPECT_THAT(message_of<Error>([&] { SceneLibrary({(folder() / "a.ply").string()}, ""); }),
              HasSubstr("is not a folder"));
  EXPECT_THAT(message_of<Error>([&] { SceneLibrary({"/nowhere/at/all"}, "", "parameter 'scenes':"); }),
              StartsWith("parameter 'scenes': /nowhere/at/all: "));
}

TEST_F(SceneLibraryTest, KeepsWhatIsHandedOverInAFolderOfItsOwnUntilItEnds) {
  fs::path own;
  {
    SceneLibrary library({}, "");
    const std::string place = library.place_for("../../my scene (1).ply", 100);
    own = fs::path(place).parent_path().parent_path();
    EXPECT_EQ(fs::path(place).filename(), "my_scene__1_.ply");
    EXPECT_EQ(fs::status(own).permissions() & (fs::perms::group_all | fs::perms::others_all),
              fs::perms::none);
    EXPECT_THAT(names(library), testing::ElementsAre("The built-in still life")) << "it is not there yet";
    std::ofstream(place) << "ply";
    library.have(place, {});
    EXPECT_EQ(library.path_of("handed-over/my_scene__1_.ply"), place);
    const std::string second = library.place_for("second.ply", 100);
    std::ofstream(second) << "ply";
    library.have(second, std::array{place});  // the first is still felt
    EXPECT_TRUE(fs::exists(place));
    const std::string third = library.place_for("third.ply", 100);
    library.have(third, std::array{second});
    EXPECT_FALSE(fs::exists(place));
    EXPECT_TRUE(fs::exists(second));
    library.drop(third);
    EXPECT_FALSE(fs::exists(fs::path(third).parent_path()));
  }
  EXPECT_FALSE(fs::exists(own));
}

TEST_F(SceneLibraryTest, TakesNoFileThatItCannotReadOrHasNoRoomFor) {
  SceneLibrary library({}, "");
  EXPECT_THAT(message_of<Error>([&] { library.place_for("a.sog", 100); }), HasSubstr("convert it first"));
  EXPECT_THAT(message_of<Error>([&] { library.place_for("a.txt", 100); }), HasSubstr("is not a scene"));
  EXPECT_THAT(message_of<Error>([&] { library.place_for("a.ply", 0); }), HasSubstr("is empty"));
  EXPECT_THAT(message_of<Error>([&] { library.place_for("a.ply", std::uint64_t{1} << 60U); }),
              HasSubstr("not enough disk space"));
}

}  // namespace
}  // namespace palpate::test

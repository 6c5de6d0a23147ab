#include <palpate/base/growing_file.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <support/full_disk.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using test::FileSizeLimit;
using test::message_of;
using test::TemporaryFile;
using testing::AllOf;
using testing::HasSubstr;

/// A file that is not there yet, in a folder of its own.
struct Place {
  TemporaryFile neighbour{""};
  std::string path = (neighbour.folder() / "new.csv").string();

  std::string bytes() const {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
};

TEST(GrowingFile, IsReadAsItGrows) {
  const Place place;
  GrowingFile file(place.path, "head\n");
  EXPECT_EQ(file.path(), place.path);
  EXPECT_EQ(place.bytes(), "head\n");
  file.append("one\ntwo\n");
  EXPECT_EQ(place.bytes(), "head\none\ntwo\n");
  file.append("");
  EXPECT_EQ(file.size(), 13U);
  file.finish();
  EXPECT_EQ(place.bytes(), "head\none\ntwo\n");
}

TEST(GrowingFile, RefusesWhatExists) {
  const Place place;
  std::ofstream(place.path) << "precious";
  EXPECT_THAT(message_of<Error>([&] { GrowingFile(place.path, "head\n"); }),
              AllOf(HasSubstr(place.path), HasSubstr("exists"), HasSubstr("another name")));
  EXPECT_EQ(place.bytes(), "precious");
  const std::string folder = place.neighbour.folder().string();
  EXPECT_THAT(message_of<Error>([&] { GrowingFile(folder, "head\n"); }), HasSubstr("exists"));
  std::filesystem::create_symlink("nowhere", folder + "/link");
  EXPECT_THAT(message_of<Error>([&] { GrowingFile(folder + "/link", "head\n"); }), HasSubstr("exists"));
}

TEST(GrowingFile, RefusesAMissingFolder) {
  const Place place;
  const std::string path = place.path + "/in/none.csv";
  EXPECT_THAT(message_of<Error>([&] { GrowingFile(path, "head\n"); }),
              AllOf(HasSubstr(path), HasSubstr("No such file"), HasSubstr("check the path")));
}

TEST(GrowingFile, RefusesAReadOnlyFolder) {
  const Place place;
  const std::filesystem::path folder = place.neighbour.folder() / "disk";
  std::filesystem::create_directory(folder);
  const test::SmallDisk disk(folder, "64k");  // root is bound by this and not by permissions
  if (disk.mounted()) {
    ASSERT_TRUE(disk.make_read_only());
  } else {
    std::filesystem::permissions(folder, std::filesystem::perms::owner_read);
  }
  EXPECT_THAT(message_of<Error>([&] { GrowingFile((folder / "new.csv").string(), "head\n"); }),
              AllOf(HasSubstr("new.csv"), HasSubstr("check the permissions")));
}

TEST(GrowingFile, WithoutRoomForItsFirstLinesIsNotThere) {
  const Place place;
  const FileSizeLimit limit(3);
  EXPECT_THAT(message_of<Error>([&] { GrowingFile(place.path, "head\n"); }),
              AllOf(HasSubstr(place.path), HasSubstr("too large")));
  EXPECT_FALSE(std::filesystem::exists(place.path));
}

TEST(GrowingFile, OfAFullDiskKeepsTheWholeLinesThatWentIn) {
  // The disk ends before, at and behind the end of a line.
  for (rlim_t room = 5; room < 13; ++room) {
    const Place place;
    GrowingFile file(place.path, "head\n");
    const FileSizeLimit limit(room);
    EXPECT_THAT(message_of<Error>([&] { file.append("one\ntwo\n"); }),
                AllOf(HasSubstr(place.path), HasSubstr("too large"), HasSubstr("limit")));
    const std::string expected = room < 9 ? "head\n" : "head\none\n";
    EXPECT_EQ(place.bytes(), expected) << room;
    EXPECT_EQ(file.size(), expected.size()) << room;
  }
}

TEST(GrowingFile, SaysThatItWasRemoved) {
  for (const bool replaced : {false, true}) {
    const Place place;
    GrowingFile file(place.path, "head\n");
    std::filesystem::remove(place.path);
    if (replaced) std::ofstream(place.path) << "another\n";
    const auto names_it = AllOf(HasSubstr(place.path), HasSubstr("was removed"), HasSubstr("lost"));
    EXPECT_THAT(message_of<Error>([&] { file.append("one\n"); }), names_it);
    EXPECT_EQ(file.size(), 5U);
    EXPECT_THAT(message_of<Error>([&] { file.finish(); }), names_it);
    EXPECT_EQ(place.bytes(), replaced ? "another\n" : "");
  }
}

TEST(GrowingFile, SaysAtItsEndThatItWasMoved) {
  const Place place;
  GrowingFile file(place.path, "head\n");
  std::filesystem::rename(place.path, place.path + ".old");
  file.append("one\n");
  EXPECT_THAT(message_of<Error>([&] { file.finish(); }),
              AllOf(HasSubstr(place.path), HasSubstr("was moved")));
  std::filesystem::rename(place.path + ".old", place.path);
  EXPECT_EQ(place.bytes(), "head\none\n");
}

}  // namespace
}  // namespace palpate

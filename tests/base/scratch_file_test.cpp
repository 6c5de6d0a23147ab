// What indices need of files: a temporary one, stamps, whether a folder can be written, output without a
// wait.
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

namespace fs = std::filesystem;
using test::entries;
using test::message_of;
using testing::AllOf;
using testing::HasSubstr;
using NamedFile = test::TemporaryFile;  // one of this test's own, with a name

TEST(TemporaryFile, ReadsWhatWasWrittenAnywhere) {
  const NamedFile beside("x");
  palpate::TemporaryFile file(beside.folder().string());
  const std::string early(5000, 'e'), late(100'000, 'l');
  file.write(1'000'000, late);
  file.write(0, early);
  file.write(2000, std::string("middle"));
  std::string out(10, '?');
  file.read(1998, out);
  EXPECT_EQ(out, "eemiddleee");
  out.assign(late.size(), '?');
  file.read(1'000'000, out);
  EXPECT_EQ(out, late);
  out.assign(4, '?');
  file.read(500'000, out);
  EXPECT_EQ(out, std::string(4, '\0')) << "a hole";
}

TEST(TemporaryFile, HasNoNameAndLeavesNothing) {
  const NamedFile beside("x");
  const auto descriptors = [] { return entries("/proc/self/fd"); };
  const std::size_t before = descriptors();
  {
    palpate::TemporaryFile file(beside.folder().string());
    file.write(0, std::string(100'000, 'x'));
    EXPECT_EQ(entries(beside.folder()), 1U);
  }
  EXPECT_EQ(entries(beside.folder()), 1U);
  EXPECT_EQ(descriptors(), before);
}

TEST(TemporaryFile, SaysWhatItCannot) {
  const NamedFile beside("x");
  const std::string missing = (beside.folder() / "missing").string();
  EXPECT_THAT(message_of<Error>([&] { palpate::TemporaryFile file(missing); }),
              AllOf(HasSubstr(missing), HasSubstr("No such file")));
  palpate::TemporaryFile file(beside.folder().string());
  file.write(0, std::string("abc"));
  std::string out(4, '?');
  EXPECT_THAT(message_of<Error>([&] { file.read(0, out); }), HasSubstr(beside.folder().string()));
}

TEST(TemporaryFile, SaysWhenThereIsNoRoom) {
  const NamedFile beside("x");
  palpate::TemporaryFile file(beside.folder().string());
  struct rlimit before {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto ignored = ::signal(SIGXFSZ, SIG_IGN);
  const struct rlimit small { 1 << 20, before.rlim_max };
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string message = message_of<Error>([&] { file.write(0, std::string(4 << 20, 'x')); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  ::signal(SIGXFSZ, ignored);
  EXPECT_THAT(message, AllOf(HasSubstr("temporary file"), HasSubstr("File too large")));
}

/// Sets mtime, and with it ctime to now.
void set_modified(const std::string& path, std::int64_t ns) {
  const timespec times[2] = {{0, UTIME_OMIT}, {ns / 1'000'000'000, ns % 1'000'000'000}};
  ASSERT_EQ(::utimensat(AT_FDCWD, path.c_str(), times, 0), 0);
}

TEST(FileStamp, TellsSizeAndTimes) {
  const NamedFile file("12345");
  set_modified(file.path(), 1'234'567'890'123'456'789);
  const FileStamp stamp = stamp_of(file.path());
  EXPECT_EQ(stamp.size, 5U);
  EXPECT_EQ(stamp.modified_ns, 1'234'567'890'123'456'789);
  EXPECT_EQ(stamp, stamp_of(file.path()));
}

TEST(FileStamp, SeesAChangeThatHidesItsTime) {
  const NamedFile file("before");
  const FileStamp before = stamp_of(file.path());
  ::usleep(20'000);  // more than the tick of the clock that stamps files
  std::ofstream(file.path(), std::ios::in | std::ios::binary) << "AFTER!";
  set_modified(file.path(), before.modified_ns);
  const FileStamp after = stamp_of(file.path());
  EXPECT_EQ(after.size, before.size);
  EXPECT_EQ(after.modified_ns, before.modified_ns);
  EXPECT_NE(after, before);
}

TEST(FileStamp, NeedsAFile) {
  const NamedFile file("x");
  const std::string missing = file.path() + ".missing";
  EXPECT_THAT(message_of<Error>([&] { stamp_of(missing); }),
              AllOf(HasSubstr(missing), HasSubstr("No such file")));
}

TEST(FolderIsWritable, GoesByThePermissions) {
  const NamedFile file("x");
  EXPECT_TRUE(folder_is_writable(file.path()));
  EXPECT_TRUE(folder_is_writable(file.path() + ".missing"));
  EXPECT_FALSE(folder_is_writable((file.folder() / "missing" / "x").string()));
  fs::permissions(file.folder(), fs::perms(0555));
  EXPECT_FALSE(folder_is_writable(file.path())) << "also for a superuser";
  fs::permissions(file.folder(), fs::perms(0755));
  EXPECT_TRUE(folder_is_writable(file.path()));
}

TEST(FolderIsWritable, LooksWhereALinkLeads) {
  const NamedFile file("x"), elsewhere("x");
  const fs::path link = file.folder() / "link";
  fs::create_symlink(elsewhere.path(), link);
  fs::permissions(elsewhere.folder(), fs::perms(0555));
  EXPECT_FALSE(folder_is_writable(link.string()));
  fs::permissions(elsewhere.folder(), fs::perms(0755));
  EXPECT_TRUE(folder_is_writable(link.string()));
}

TEST(FolderIsWritable, TakesARelativeName) {
  const NamedFile file("x");
  const fs::path before = fs::current_path();
  fs::current_path(file.folder());
  const bool writable = folder_is_writable("name");
  fs::permissions(file.folder(), fs::perms(0555));
  const bool read_only = !folder_is_writable("name");
  fs::permissions(file.folder(), fs::perms(0755));
  fs::current_path(before);
  EXPECT_TRUE(writable && read_only);
}

TEST(OutputFileWithoutSync, AppearsWholeAllTheSame) {
  const NamedFile earlier("before");
  const std::string large(5 << 20, 'x'), small = "y";
  {
    OutputFile file(earlier.path());
    file.write(small);
    file.write(large);  // more than is buffered: must not overtake what is
    file.write(small);
    EXPECT_EQ(earlier.bytes(), "before");
    file.commit(OutputFile::Sync::kNo);
    EXPECT_EQ(earlier.bytes(), small + large + small);
  }
  EXPECT_EQ(earlier.bytes(), small + large + small);
  EXPECT_EQ(entries(earlier.folder()), 1U);
}

}  // namespace
}  // namespace palpate

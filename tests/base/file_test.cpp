#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <support/full_disk.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

namespace fs = std::filesystem;
using test::entries;
using test::message_of;
using test::TemporaryFile;
using testing::AllOf;
using testing::HasSubstr;

std::string bytes_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

mode_t mode_of(const fs::path& path) {
  struct stat status {};
  EXPECT_EQ(::stat(path.c_str(), &status), 0);
  return status.st_mode & 07777;
}

/// Sets the umask for a scope.
class Umask {
 public:
  explicit Umask(mode_t mask) : before_(::umask(mask)) {}
  ~Umask() { ::umask(before_); }

 private:
  mode_t before_;
};

TEST(InputFile, ReadsAtAnyOffset) {
  const TemporaryFile temporary("0123456789");
  const InputFile file(temporary.path());
  EXPECT_EQ(file.path(), temporary.path());
  EXPECT_EQ(file.size(), 10U);
  std::string out(4, '?');
  file.read(3, out);
  EXPECT_EQ(out, "3456");
  file.read(0, out);
  EXPECT_EQ(out, "0123");
  EXPECT_EQ(file.read_some(8, out), 2U);
  EXPECT_EQ(out, "8923");
  EXPECT_EQ(file.read_some(100, out), 0U);
}

TEST(InputFile, SaysWhereAFileEndsEarly) {
  const TemporaryFile temporary("0123456789");
  const InputFile file(temporary.path());
  std::string out(8, '?');
  EXPECT_THAT(message_of<Error>([&] { file.read(5, out); }),
              AllOf(HasSubstr(temporary.path()), HasSubstr("byte 10")));
}

TEST(InputFile, ReadsOnAfterAMove) {
  const TemporaryFile temporary("abc");
  InputFile first(temporary.path());
  const InputFile second(std::move(first));
  std::string out(3, '?');
  second.read(0, out);
  EXPECT_EQ(out, "abc");
  EXPECT_EQ(second.size(), 3U);
}

TEST(InputFile, RefusesWhatIsNoFile) {
  const TemporaryFile temporary("");
  const std::string missing = temporary.path() + ".missing";
  EXPECT_THAT(message_of<Error>([&] { InputFile file(missing); }),
              AllOf(HasSubstr(missing), HasSubstr("No such file")));
  EXPECT_THAT(message_of<Error>([&] { InputFile file(temporary.folder().string()); }),
              HasSubstr("is a folder"));
  EXPECT_THAT(message_of<Error>([&] { InputFile file("/dev/null"); }), HasSubstr("not a regular file"));
  EXPECT_THAT(message_of<Error>([&] { InputFile file(temporary.path() + "/x"); }),
              HasSubstr("Not a directory"));
}

TEST(InputFile, DoesNotWaitForAFifo) {
  const TemporaryFile temporary("");
  const std::string fifo = temporary.path() + ".fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_THAT(message_of<Error>([&] { InputFile file(fifo); }),
              AllOf(HasSubstr(fifo), HasSubstr("not a regular file")));
}

TEST(InputFile, LeavesNoDescriptorBehind) {
  const TemporaryFile temporary("abc");
  const auto descriptors = [] { return entries("/proc/self/fd"); };
  const std::size_t before = descriptors();
  for (int i = 0; i < 10; ++i) {
    InputFile file(temporary.path());
    InputFile moved(std::move(file));
    message_of<Error>([&] { InputFile folder(temporary.folder().string()); });
    OutputFile out(temporary.path() + ".out");
    OutputFile committed(temporary.path() + ".committed");
    committed.commit();
  }
  EXPECT_EQ(descriptors(), before);
}

TEST(ReadTextFile, ReadsAllUpToALimit) {
  const TemporaryFile temporary("some text\n");
  EXPECT_EQ(read_text_file(temporary.path(), 10), "some text\n");
  EXPECT_THAT(message_of<Error>([&] { read_text_file(temporary.path(), 9); }),
              AllOf(HasSubstr(temporary.path()), HasSubstr("10 bytes")));
  const TemporaryFile nothing("");
  EXPECT_EQ(read_text_file(nothing.path(), 10), "");
}

TEST(OutputFile, AppearsWholeOnCommit) {
  const TemporaryFile temporary("");
  const fs::path path = temporary.folder() / "out";
  std::string expected;
  {
    OutputFile file(path.string());
    for (int i = 0; i < 300000; ++i) {  // more than it buffers
      file.write("line " + std::to_string(i) + "\n");
      expected += "line " + std::to_string(i) + "\n";
    }
    EXPECT_FALSE(fs::exists(path));
    file.commit();
    EXPECT_EQ(bytes_of(path), expected);
  }
  EXPECT_EQ(bytes_of(path), expected);
  EXPECT_EQ(entries(temporary.folder()), 2U);  // it, and the empty one
}

TEST(OutputFile, LeavesNothingWithoutACommit) {
  const TemporaryFile temporary("");
  {
    OutputFile file((temporary.folder() / "out").string());
    file.write(std::string(3 << 20, 'x'));
  }
  EXPECT_EQ(entries(temporary.folder()), 1U);
}

TEST(OutputFile, LeavesAnEarlierFileAloneWithoutACommit) {
  const TemporaryFile temporary("before");
  {
    OutputFile file(temporary.path());
    file.write(std::string(3 << 20, 'x'));
    EXPECT_EQ(temporary.bytes(), "before");
  }
  EXPECT_EQ(temporary.bytes(), "before");
  EXPECT_EQ(entries(temporary.folder()), 1U);
}

TEST(OutputFile, ReplacesAnEarlierFileOnCommit) {
  const TemporaryFile temporary("before, and longer");
  write_file(temporary.path(), "after");
  EXPECT_EQ(temporary.bytes(), "after");
  EXPECT_EQ(entries(temporary.folder()), 1U);
}

TEST(OutputFile, WhoReadsTheOldFileKeepsIt) {
  const TemporaryFile temporary("before");
  const InputFile old(temporary.path());
  write_file(temporary.path(), "AFTER!");
  std::string out(6, '?');
  old.read(0, out);
  EXPECT_EQ(out, "before");
}

TEST(OutputFile, HasTheModeOfAnyNewFile) {
  const TemporaryFile temporary("");
  const auto written_under = [&](mode_t mask) {
    const Umask set(mask);
    const fs::path path = temporary.folder() / "out";
    write_file(path.string(), "x");
    const mode_t mode = mode_of(path);
    fs::remove(path);
    return mode;
  };
  EXPECT_EQ(written_under(022), 0644U);
  EXPECT_EQ(written_under(077), 0600U);
  EXPECT_EQ(written_under(0), 0666U);
}

TEST(OutputFile, FollowsASymbolicLink) {
  const TemporaryFile temporary("before");
  fs::create_directory(temporary.folder() / "elsewhere");
  const fs::path target = temporary.folder() / "elsewhere" / "target", link = temporary.folder() / "link";
  std::ofstream(target) << "before";
  fs::create_symlink("elsewhere/target", link);
  write_file(link.string(), "after");
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(bytes_of(target), "after");
  EXPECT_EQ(entries(temporary.folder() / "elsewhere"), 1U);
}

TEST(OutputFile, FollowsASymbolicLinkToAFileThatIsNotThereYet) {
  const TemporaryFile temporary("");
  const fs::path target = temporary.folder() / "target", link = temporary.folder() / "link";
  fs::create_symlink("target", link);
  write_file(link.string(), "after");
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(bytes_of(target), "after");
}

TEST(OutputFile, TakesARelativeName) {
  const TemporaryFile temporary("");
  const fs::path before = fs::current_path();
  fs::current_path(temporary.folder());
  write_file("here", "x");
  fs::current_path(before);
  EXPECT_EQ(bytes_of(temporary.folder() / "here"), "x");
}

TEST(OutputFile, TakesTheLongestNameAFileMayHave) {
  const TemporaryFile temporary("");
  const fs::path path = temporary.folder() / std::string(255, 'n');
  write_file(path.string(), "x");
  EXPECT_EQ(bytes_of(path), "x");
}

TEST(OutputFile, RefusesAFolderAndAMissingFolder) {
  const TemporaryFile temporary("");
  EXPECT_THAT(message_of<Error>([&] { OutputFile file(temporary.folder().string()); }),
              AllOf(HasSubstr(temporary.folder().string()), HasSubstr("folder")));
  const std::string path = (temporary.folder() / "missing" / "out").string();
  EXPECT_THAT(message_of<Error>([&] { OutputFile file(path); }),
              AllOf(HasSubstr(path), HasSubstr("No such file")));
  EXPECT_THAT(message_of<Error>([&] { OutputFile file(temporary.path() + "/out"); }),
              HasSubstr(temporary.path()));
}

TEST(OutputFile, SaysWhenTheDiskIsFull) {
  EXPECT_THAT(message_of<Error>([] { write_file("/dev/full", "x"); }),
              AllOf(HasSubstr("/dev/full"), HasSubstr("No space left")));
  // Larger than the buffer: already write() finds out.
  OutputFile file("/dev/full");
  EXPECT_THAT(message_of<Error>([&] { file.write(std::string(3 << 20, 'x')); }), HasSubstr("No space left"));
}

TEST(OutputFile, AFailedWriteLeavesTheEarlierFile) {
  const TemporaryFile temporary("before");
  const test::FileSizeLimit limit(1 << 20);
  EXPECT_THAT(message_of<Error>([&] { write_file(temporary.path(), std::string(4 << 20, 'x')); }),
              AllOf(HasSubstr(temporary.path()), HasSubstr("File too large")));
  EXPECT_EQ(temporary.bytes(), "before");
  EXPECT_EQ(entries(temporary.folder()), 1U);
}

TEST(OutputFile, WritesThroughADevice) {
  write_file("/dev/null", "x");
  struct stat status {};
  ASSERT_EQ(::stat("/dev/null", &status), 0);
  EXPECT_TRUE(S_ISCHR(status.st_mode));
}

TEST(OutputFile, WritesThroughAFifo) {
  const TemporaryFile temporary("");
  const std::string fifo = (temporary.folder() / "fifo").string();
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  std::string received;
  std::thread reader([&] { received = bytes_of(fifo); });
  const std::string sent(3 << 20, 'x');
  write_file(fifo, sent);
  reader.join();
  EXPECT_EQ(received.size(), sent.size());
  EXPECT_TRUE(fs::is_fifo(fifo));
  EXPECT_EQ(entries(temporary.folder()), 2U);
}

TEST(SameFile, SeesThroughLinksAndDetours) {
  const TemporaryFile temporary("x");
  const fs::path link = temporary.folder() / "link", hard = temporary.folder() / "hard",
                 other = temporary.folder() / "other";
  fs::create_symlink(temporary.path(), link);
  fs::create_hard_link(temporary.path(), hard);
  std::ofstream(other) << "x";
  EXPECT_TRUE(same_file(temporary.path(), temporary.path()));
  EXPECT_TRUE(same_file(temporary.path(), (temporary.folder() / "." / "file").string()));
  EXPECT_TRUE(same_file(link.string(), temporary.path()));
  EXPECT_TRUE(same_file(hard.string(), temporary.path()));
  EXPECT_FALSE(same_file(other.string(), temporary.path()));
  EXPECT_FALSE(same_file(temporary.path(), temporary.path() + ".missing"));
  EXPECT_FALSE(same_file("missing", "missing"));
}

TEST(Error, IsOneLineOfPrintableText) {
  const Error error("{}: line {}\nsecond\x1b[0m\ttab", "name\r", 7);
  EXPECT_STREQ(error.what(), "name?: line 7?second?[0m?tab");
}

TEST(Error, HasNoCharactersThatReorderOrBreakTheLine) {
  for (const char* sign : {"\u2028", "\u202e", "\u2066", "\u2067", "\u2068", "\u2069"})
    EXPECT_EQ(printable(std::string("a") + sign + "b"), "a???b");
  for (const char* sign : {"\u2027", "\u202f", "\u2065", "\u206a", "\u20ac"})
    EXPECT_EQ(printable(sign), sign);
}

}  // namespace
}  // namespace palpate

// A copy of a file that processes share, and nobody can change.
#include <palpate/base/shared_copy.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>
#include <string>

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <support/temporary_file.h>

namespace palpate::test {
namespace {

namespace fs = std::filesystem;

/// Has links in a folder of its own.
class SharedCopyTest : public testing::Test {
 protected:
  void SetUp() override { ::setenv("XDG_RUNTIME_DIR", file_.folder().c_str(), 1); }
  void TearDown() override { ::unsetenv("XDG_RUNTIME_DIR"); }

  static std::string text_of(const SharedCopy& copy) {
    return {reinterpret_cast<const char*>(copy.bytes().data()), copy.bytes().size()};
  }
  /// Of the memory that is mapped there.
  static std::uint64_t inode_of(const SharedCopy& copy) {
    const auto place = reinterpret_cast<std::uintptr_t>(copy.bytes().data());
    std::ifstream maps("/proc/self/maps");
    for (std::string line; std::getline(maps, line);) {
      std::uintptr_t begin = 0, end = 0;
      std::uint64_t inode = 0;
      char dash = 0;
      std::string rights, offset, device;
      std::istringstream(line) >> std::hex >> begin >> dash >> end >> rights >> offset >> device >>
          std::dec >> inode;
      if (begin <= place && place < end) return inode;
    }
    return 0;
  }
  std::vector<fs::path> links() const {
    std::vector<fs::path> all;
    for (const auto& entry : fs::directory_iterator(file_.folder()))
      if (entry.is_symlink()) all.push_back(entry.path());
    return all;
  }
  static auto descriptors() {
    return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator());
  }

  const std::string bytes_ = std::string(3 * 4096 + 17, 'a') + "end";
  const TemporaryFile file_{bytes_};
};

TEST_F(SharedCopyTest, IsInMemoryOnce) {
  const SharedCopy first(file_.path()), second(file_.path());
  EXPECT_EQ(text_of(first), bytes_);
  EXPECT_EQ(text_of(second), bytes_);
  EXPECT_NE(inode_of(first), 0U);
  EXPECT_EQ(inode_of(first), inode_of(second));
}

TEST_F(SharedCopyTest, IsSharedByProcesses) {
  const SharedCopy here(file_.path());
  int pipe[2];
  ASSERT_EQ(::pipe(pipe), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const SharedCopy there(file_.path());
    const std::uint64_t inode = text_of(there) == bytes_ ? inode_of(there) : 0;
    [[maybe_unused]] const auto written = ::write(pipe[1], &inode, sizeof(inode));
    ::_exit(0);
  }
  std::uint64_t inode = 0;
  EXPECT_EQ(::read(pipe[0], &inode, sizeof(inode)), static_cast<ssize_t>(sizeof(inode)));
  ::waitpid(child, nullptr, 0);
  EXPECT_EQ(inode, inode_of(here));
  for (const int end : pipe) ::close(end);
}

TEST_F(SharedCopyTest, NobodyCanChangeIt) {
  const SharedCopy copy(file_.path());
  ASSERT_EQ(links().size(), 1U);
  const int writable = ::open(links()[0].c_str(), O_RDWR);
  if (writable >= 0) {
    EXPECT_EQ(::write(writable, "x", 1), -1);
    EXPECT_EQ(::ftruncate(writable, 1), -1);
    EXPECT_EQ(::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, writable, 0), MAP_FAILED);
    ::close(writable);
  }
  EXPECT_EQ(text_of(copy), bytes_);
}

TEST_F(SharedCopyTest, AFileThatHasChangedIsAnotherOne) {
  const SharedCopy before(file_.path());
  std::ofstream(file_.path(), std::ios::binary | std::ios::in) << "b";
  const SharedCopy after(file_.path());
  EXPECT_EQ(text_of(before), bytes_);
  EXPECT_EQ(text_of(after), "b" + bytes_.substr(1));
}

TEST_F(SharedCopyTest, TakesNothingThatIsNotSealed) {
  std::string link;
  {
    const SharedCopy copy(file_.path());
    link = links().at(0);
  }
  EXPECT_TRUE(links().empty()) << "the link goes with who made it";
  const TemporaryFile planted(std::string(bytes_.size(), 'x'));
  fs::create_symlink(planted.path(), link);
  EXPECT_EQ(text_of(SharedCopy(file_.path())), bytes_);
  fs::remove(link);
  const int memory = ::memfd_create("planted", MFD_ALLOW_SEALING);
  ASSERT_EQ(::ftruncate(memory, static_cast<off_t>(bytes_.size())), 0);
  fs::create_symlink(fmt::format("/proc/{}/fd/{}", ::getpid(), memory), link);
  EXPECT_EQ(text_of(SharedCopy(file_.path())), bytes_);
  ::close(memory);
}

// The link of a process that was killed, whose number another process has now, with other memory of that
// size.
TEST_F(SharedCopyTest, TakesNothingThatIsOfAnotherFile) {
  std::string link;
  {
    const SharedCopy copy(file_.path());
    link = links().at(0);
  }
  const TemporaryFile other(std::string(bytes_.size(), 'x'));
  const SharedCopy others(other.path());
  fs::create_symlink(fs::read_symlink(links().at(0)), link);
  EXPECT_EQ(text_of(SharedCopy(file_.path())), bytes_);
}

TEST_F(SharedCopyTest, OutlivesWhoMadeIt) {
  auto first = std::make_unique<SharedCopy>(file_.path());
  const SharedCopy second(file_.path());
  first.reset();
  EXPECT_EQ(text_of(second), bytes_);
  const SharedCopy third(file_.path());
  EXPECT_EQ(text_of(third), bytes_);
}

TEST_F(SharedCopyTest, LeavesNothingBehind) {
  const auto before = descriptors();
  { const SharedCopy first(file_.path()), second(file_.path()); }
  EXPECT_EQ(descriptors(), before);
  EXPECT_TRUE(links().empty());
}

TEST_F(SharedCopyTest, WorksWhereNothingCanBeShown) {
  ::setenv("XDG_RUNTIME_DIR", "/proc", 1);
  EXPECT_EQ(text_of(SharedCopy(file_.path())), bytes_);
}

}  // namespace
}  // namespace palpate::test

// A file as memory: whole, shared, and not hung up by what is no file.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/base/mapped_file.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

namespace fs = std::filesystem;
using test::message_of;
using testing::AllOf;
using testing::HasSubstr;

std::string text_of(const MappedFile& file) {
  return {reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()};
}

/// Lines of this process's list of mappings that name `path`.
std::size_t mappings_of(const std::string& path) {
  std::ifstream maps("/proc/self/maps");
  std::size_t count = 0;
  for (std::string line; std::getline(maps, line);) count += line.ends_with(path);
  return count;
}

TEST(MappedFile, HasAllBytes) {
  std::string bytes(3 * 4096 + 17, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 31 % 251);
  const test::TemporaryFile temporary(bytes);
  const MappedFile file(temporary.path());
  EXPECT_EQ(file.path(), temporary.path());
  EXPECT_EQ(text_of(file), bytes);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(file.bytes().data()) % 4096, 0U);
}

TEST(MappedFile, StaysAsItWasWhenTheFileIsReplacedOrRemoved) {
  const test::TemporaryFile temporary("before");
  const MappedFile file(temporary.path());
  write_file(temporary.path(), "AFTER!");
  EXPECT_EQ(text_of(file), "before");
  fs::remove(temporary.path());
  EXPECT_EQ(text_of(file), "before");
}

TEST(MappedFile, LeavesNoDescriptorAndNoMappingBehind) {
  const test::TemporaryFile temporary("abc");
  const auto descriptors = [] {
    return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator());
  };
  const auto before = descriptors();
  {
    const MappedFile file(temporary.path());
    EXPECT_EQ(mappings_of(temporary.path()), 1U);
    EXPECT_EQ(descriptors(), before) << "a mapping needs no descriptor";
  }
  EXPECT_EQ(mappings_of(temporary.path()), 0U);
}

TEST(MappedFile, RefusesWhatIsNoFile) {
  const test::TemporaryFile temporary("");
  const std::string missing = temporary.path() + ".missing", folder = temporary.folder().string(),
                    fifo = temporary.path() + ".fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const auto refusal = [](const std::string& path) {
    return message_of<Error>([&] { MappedFile file(path); });
  };
  EXPECT_THAT(refusal(missing), AllOf(HasSubstr(missing), HasSubstr("No such file")));
  EXPECT_THAT(refusal(temporary.path()), AllOf(HasSubstr(temporary.path()), HasSubstr("empty")));
  EXPECT_THAT(refusal(folder), AllOf(HasSubstr(folder), HasSubstr("not a regular file")));
  EXPECT_THAT(refusal(fifo), AllOf(HasSubstr(fifo), HasSubstr("not a regular file")));
  EXPECT_THAT(refusal("/dev/null"), HasSubstr("not a regular file"));
}

// Cut, written over and gone: a copy has what it had.
TEST(MappedFile, ACopyIsOutOfReach) {
  const std::string bytes(5 * 4096 + 3, 'a');
  const test::TemporaryFile temporary(bytes);
  const MappedFile copy(temporary.path(), FileMemory::kOwn);
  EXPECT_EQ(mappings_of(temporary.path()), 0U);
  std::ofstream(temporary.path(), std::ios::binary | std::ios::in) << std::string(4096, 'b');
  fs::resize_file(temporary.path(), 1);
  EXPECT_EQ(text_of(copy), bytes);
  fs::remove(temporary.path());
  EXPECT_EQ(text_of(copy), bytes);
}

TEST(MappedFile, ACopyRefusesWhatAMapDoes) {
  for (const FileMemory memory : {FileMemory::kShared, FileMemory::kOwn}) {
    EXPECT_THAT(message_of<Error>([&] { MappedFile file("nowhere.bin", memory); }), HasSubstr("nowhere.bin"));
    const test::TemporaryFile empty("");
    EXPECT_THAT(message_of<Error>([&] { MappedFile file(empty.path(), memory); }), HasSubstr("is empty"));
    EXPECT_THAT(message_of<Error>([&] { MappedFile file("/dev/null", memory); }),
                HasSubstr("not a regular file"));
  }
}

}  // namespace
}  // namespace palpate

/// \file
/// Fuzzer input as a file in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <sys/mman.h>
#include <unistd.h>

namespace palpate::fuzz {

/// A file in memory that every input overwrites, linked under a name with the required extension.
class InputFile {
 public:
  /// Writes `size` bytes of `data`. \returns path of the file, which is named `name`
  std::string hold(const std::uint8_t* data, std::size_t size, const std::string& name) {
    std::size_t done = 0;
    if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) std::abort();
    while (done < size) {
      const ssize_t n = ::pwrite(descriptor_, data + done, size - done, static_cast<off_t>(done));
      if (n <= 0) std::abort();
      done += static_cast<std::size_t>(n);
    }
    const std::filesystem::path link = folder_ / name;
    if (!std::filesystem::is_symlink(link)) {
      std::filesystem::create_symlink("/proc/self/fd/" + std::to_string(descriptor_), link);
    }
    return link.string();
  }

  InputFile()
      : folder_(std::filesystem::temp_directory_path() / ("palpate-fuzz-" + std::to_string(::getpid()))) {
    descriptor_ = ::memfd_create("input", 0);
    if (descriptor_ < 0) std::abort();
    std::filesystem::create_directories(folder_);
  }
  ~InputFile() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

 private:
  std::filesystem::path folder_;
  int descriptor_ = -1;
};

/// Aborts the process, and with it the fuzzer, if a property does not hold.
inline void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace palpate::fuzz

#include <palpate/base/shared_copy.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <palpate/base/clock.h>
#include <palpate/base/error.h>
#include <palpate/base/file.h>

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr int kSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE;

/// File descriptor that is closed on destruction.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;

  int get() const { return number_; }
  int release() { return std::exchange(number_, -1); }
  explicit operator bool() const { return number_ >= 0; }

 private:
  int number_;
};

Descriptor open_to_read(const std::string& path) {
  return Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
}

std::string path_of(const Descriptor& descriptor) {
  return fmt::format("/proc/{}/fd/{}", ::getpid(), descriptor.get());
}

/// Path of the link to the memory of `file`. It contains inode, size and timestamps, so that a changed file
/// has another link.
std::string link_of(const struct stat& file) {
  // Nothing here sets variables. NOLINTNEXTLINE(concurrency-mt-unsafe)
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  std::error_code ignored;
  const fs::path folder = runtime != nullptr && fs::is_directory(runtime, ignored)
                              ? fs::path(runtime)
                              : fs::temp_directory_path(ignored);
  return folder / fmt::format("palpate-{}-{:x}-{:x}-{:x}-{:x}.{:09}-{:x}.{:09}", ::geteuid(), file.st_dev,
                              file.st_ino, file.st_size, file.st_mtim.tv_sec, file.st_mtim.tv_nsec,
                              file.st_ctim.tv_sec, file.st_ctim.tv_nsec);
}

bool is_sealed(const Descriptor& memory) {
  const int seals = ::fcntl(memory.get(), F_GET_SEALS);
  return seals >= 0 && (seals & kSeals) == kSeals;
}

/// Returns true if the last 4 KiB of two files are equal. A link outlives a killed process, whose number may
/// then belong to another process with other memory. The last page of an index identifies its source.
bool end_alike(const Descriptor& a, const Descriptor& b, off_t size) {
  std::array<char, 4096> of_a, of_b;
  const off_t at = std::max<off_t>(0, size - static_cast<off_t>(of_a.size()));
  const ssize_t length = ::pread(a.get(), of_a.data(), of_a.size(), at);
  return length > 0 && ::pread(b.get(), of_b.data(), of_b.size(), at) == length &&
         std::equal(of_a.begin(), of_a.begin() + length, of_b.begin());
}

/// Opens the memory behind `link`, provided that it is verifiably an immutable copy of `file`.
Descriptor find(const std::string& link, const Descriptor& file, const struct stat& of_file) {
  Descriptor found = open_to_read(link);
  struct stat status {};
  const bool is_it = found && ::fstat(found.get(), &status) == 0 && status.st_uid == ::geteuid() &&
                     status.st_size == of_file.st_size && is_sealed(found) &&
                     end_alike(found, file, of_file.st_size);
  return is_it ? std::move(found) : Descriptor(-1);
}

/// Copies the file into sealed memory. \throws Error
Descriptor make(const std::string& path) {
  const InputFile file(path);
  const Descriptor memory(::memfd_create("palpate", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!memory) throw_file_error(path, "be loaded into memory", errno);
  std::vector<char> chunk(std::size_t{1} << 20);
  for (std::uint64_t at = 0; at < file.size();) {
    const std::size_t size = std::min<std::uint64_t>(chunk.size(), file.size() - at);
    file.read(at, {chunk.data(), size});
    for (std::size_t done = 0; done < size;) {
      const ssize_t written = ::write(memory.get(), chunk.data() + done, size - done);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) throw_file_error(path, "be loaded into memory", errno);
      done += static_cast<std::size_t>(written);
    }
    at += size;
  }
  // Sealed before it is reopened read-only: the kernel maps sealed memory through such a descriptor only.
  if (::fcntl(memory.get(), F_ADD_SEALS, kSeals | F_SEAL_SEAL) != 0)
    throw_file_error(path, "be loaded into memory", errno);
  return open_to_read(path_of(memory));
}

/// Locks a file, so that of several processes that start at once one copies it and the others wait. Gives up
/// after kPatience, in case that process hangs.
void lock(const Descriptor& file) {
  constexpr double kPatience = 30.0, kLook = 5e-3;  // s
  const double until = monotonic_now() + kPatience;
  while (::flock(file.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK && monotonic_now() < until)
    sleep_until(monotonic_now() + kLook);
}

/// Creates `link` to `memory`. \returns false on failure.
bool show(const Descriptor& memory, const std::string& link) {
  const std::string made = fmt::format("{}.{}", link, ::getpid());
  if (::symlink(path_of(memory).c_str(), made.c_str()) != 0) return false;
  if (::rename(made.c_str(), link.c_str()) == 0) return true;
  ::unlink(made.c_str());
  return false;
}

}  // namespace

SharedCopy::SharedCopy(const std::string& path) {
  const Descriptor file = open_to_read(path);
  struct stat status {};
  if (!file) throw_file_error(path, "open", errno);
  if (::fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode))
    throw Error("{}: is not a regular file", path);
  if (status.st_size == 0) throw Error("{}: is empty", path);
  lock(file);  // held until `file` is closed
  const std::string link = link_of(status);
  Descriptor found = find(link, file, status);
  const bool is_new = !found;
  Descriptor memory = is_new ? make(path) : std::move(found);
  const auto size = static_cast<std::size_t>(status.st_size);
  void* address = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, memory.get(), 0);
  if (address == MAP_FAILED) throw_file_error(path, "be loaded into memory", errno);
  if (is_new && show(memory, link)) link_ = link;
  bytes_ = {static_cast<const std::byte*>(address), size};
  descriptor_ = memory.release();
}

SharedCopy::~SharedCopy() {
  ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
  std::error_code ignored;
  const std::string own = fmt::format("/proc/{}/fd/{}", ::getpid(), descriptor_);
  if (!link_.empty() && fs::read_symlink(link_, ignored) == own) ::unlink(link_.c_str());
  ::close(descriptor_);
}

}  // namespace palpate

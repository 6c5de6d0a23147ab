#include <palpate/base/file.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <palpate/base/error.h>

namespace palpate {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxName = 255;  // bytes of a file name
constexpr mode_t kMode = 0666;         // less the user's umask, as any program's output

/// Advice to the user for a failed system call.
std::string_view advice(int error_number) {
  switch (error_number) {
    case ENOENT: return "; check the path";
    case EACCES:
    case EPERM:
    case EROFS: return "; check the permissions";
    case ENOSPC:
    case EDQUOT: return "; free some space or choose another folder";
    case EFBIG: return "; raise the limit on the size of files";
    default: return "";
  }
}

int retry_open(const char* path, int flags, mode_t mode = 0) {
  int descriptor = -1;
  do descriptor = ::open(path, flags | O_CLOEXEC, mode);
  while (descriptor < 0 && errno == EINTR);
  return descriptor;
}

/// Returns `path` with symbolic links resolved, including a link whose target does not exist.
std::string resolve_links(const std::string& path) {
  namespace fs = std::filesystem;
  constexpr int kMaxLinks = 40;  // as many as Linux follows
  std::error_code ignored;
  fs::path resolved = path;
  for (int i = 0; i < kMaxLinks && fs::is_symlink(resolved, ignored); ++i) {
    resolved = resolved.parent_path() / fs::read_symlink(resolved, ignored);
  }
  return resolved.string();
}

/// Fills `out` from byte `offset`. \returns the number of bytes read: fewer at the end of the file or on an
/// error. Sets errno, to 0 if there was no error.
std::size_t read_at(int descriptor, std::uint64_t offset, std::span<char> out) {
  std::size_t done = 0;
  errno = 0;
  while (done < out.size()) {
    const ssize_t n =
        ::pread(descriptor, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) {
      errno = 0;
      continue;
    }
    if (n <= 0) break;
    done += static_cast<std::size_t>(n);
  }
  return done;
}

}  // namespace

void throw_file_error(const std::string& path, std::string_view action, int error_number) {
  throw Error("{}: cannot {}: {}{}", path, action, error_text(error_number), advice(error_number));
}

InputFile::InputFile(const std::string& path) : path_(path) {
  // O_NONBLOCK: opening a FIFO that has no writer must not block.
  descriptor_ = retry_open(path.c_str(), O_RDONLY | O_NONBLOCK);
  if (descriptor_ < 0) throw_file_error(path, "open", errno);
  struct stat status {};
  const bool known = ::fstat(descriptor_, &status) == 0;
  if (!known || !S_ISREG(status.st_mode)) {
    ::close(descriptor_);
    throw Error("{}: {}; give a regular file", path,
                known && S_ISDIR(status.st_mode) ? "is a folder" : "is not a regular file");
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

InputFile::InputFile(InputFile&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_) {}

std::size_t InputFile::read_some(std::uint64_t offset, std::span<char> out) const {
  const std::size_t done = read_at(descriptor_, offset, out);
  if (errno != 0) throw Error("{}: cannot read at byte {}: {}", path_, offset + done, error_text(errno));
  return done;
}

void InputFile::read(std::uint64_t offset, std::span<char> out) const {
  const std::size_t got = read_some(offset, out);
  if (got != out.size()) {
    throw Error("{}: ends at byte {}, {} bytes early; the file changed while it was read", path_,
                offset + got, out.size() - got);
  }
}

std::string read_text_file(const std::string& path, std::uint64_t max_bytes) {
  const InputFile file(path);
  if (file.size() > max_bytes) {
    throw Error("{}: has {} bytes; the limit for such a file is {}", path, file.size(), max_bytes);
  }
  std::string text(file.size(), '\0');
  file.read(0, text);
  return text;
}

void refuse_dash(const std::string& path) {
  if (path == "-") throw Error("-: is no file name; use /dev/stdout, or ./- for a file of that name");
}

OutputFile::OutputFile(std::string path) : path_(std::move(path)) {
  namespace fs = std::filesystem;
  refuse_dash(path_);
  std::error_code ignored;
  const fs::file_status status = fs::status(path_, ignored);
  if (fs::is_directory(status)) throw Error("{}: cannot write: is a folder; give a file name", path_);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    direct_ = true;
    descriptor_ = retry_open(path_.c_str(), O_WRONLY);
    if (descriptor_ < 0) fail("open for writing", errno);
    return;
  }
  target_ = resolve_links(path_);
  if (fs::path(target_).filename().string().size() > kMaxName) fail("open for writing", ENAMETOOLONG);
  const fs::path folder = fs::path(target_).parent_path();
  folder_ = (folder.empty() ? fs::path(".") : folder).string();
  descriptor_ = retry_open(folder_.c_str(), O_WRONLY | O_TMPFILE, kMode);
  if (descriptor_ < 0) {  // a file system without unnamed files
    std::string name = folder_ + "/.palpate-XXXXXX";
    descriptor_ = ::mkostemp(name.data(), O_CLOEXEC);
    if (descriptor_ < 0) fail("open for writing", errno);
    temporary_ = name;
    const mode_t mask = ::umask(0);
    ::umask(mask);
    ::fchmod(descriptor_, kMode & ~mask);
  }
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void OutputFile::fail(std::string_view action, int error_number) const {
  throw_file_error(path_, action, error_number);
}

void OutputFile::write(std::string_view bytes) {
  if (bytes.size() >= kBufferBytes) {
    flush();
    write_through(bytes);
    return;
  }
  buffer_ += bytes;
  if (buffer_.size() >= kBufferBytes) flush();
}

void OutputFile::flush() {
  write_through(buffer_);
  buffer_.clear();
}

void OutputFile::write_through(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(descriptor_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail("write", errno);
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
}

void OutputFile::commit(Sync sync) {
  flush();
  if (direct_) {
    if (::close(std::exchange(descriptor_, -1)) != 0) fail("write", errno);
    return;
  }
  struct stat earlier {};
  if (::stat(target_.c_str(), &earlier) == 0) ::fchmod(descriptor_, earlier.st_mode & 07777);
  if (sync == Sync::kYes && ::fsync(descriptor_) != 0) fail("write", errno);
  if (temporary_.empty()) {
    // linkat() cannot replace a file, so the unnamed file gets a name of its own first.
    const std::string source = "/proc/self/fd/" + std::to_string(descriptor_);
    for (int attempt = 0; temporary_.empty(); ++attempt) {
      const std::string name = folder_ + fmt::format("/.palpate-{}-{}", ::getpid(), attempt);
      if (::linkat(AT_FDCWD, source.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0) {
        temporary_ = name;
      } else if (errno != EEXIST) {
        fail("write", errno);
      }
    }
  }
  // Some file systems report a full disk only here.
  if (::close(std::exchange(descriptor_, -1)) != 0) fail("write", errno);
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail("write", errno);
  temporary_.clear();
}

namespace {

/// Folder of the file `path`, with links to the file resolved.
std::string folder_of(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(resolve_links(path)).parent_path();
  return folder.empty() ? "." : folder.string();
}

}  // namespace

TemporaryFile::TemporaryFile(std::string folder) : folder_(std::move(folder)) {
  descriptor_ = retry_open(folder_.c_str(), O_RDWR | O_TMPFILE, kMode);
  if (descriptor_ >= 0) return;
  std::string name = folder_ + "/.palpate-XXXXXX";  // a file system without unnamed files
  descriptor_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (descriptor_ < 0) throw Error("{}: cannot make a temporary file: {}", folder_, error_text(errno));
  ::unlink(name.c_str());
}

TemporaryFile::~TemporaryFile() { ::close(descriptor_); }

void TemporaryFile::write(std::uint64_t offset, std::span<const char> bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n =
        ::pwrite(descriptor_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0)
      throw Error("{}: cannot write a temporary file: {}{}", folder_, error_text(errno), advice(errno));
    done += static_cast<std::size_t>(n);
  }
}

void TemporaryFile::read(std::uint64_t offset, std::span<char> out) const {
  if (read_at(descriptor_, offset, out) == out.size()) return;
  throw Error("{}: cannot read a temporary file: {}", folder_, error_text(errno != 0 ? errno : EIO));
}

FileStamp stamp_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) throw Error("{}: cannot open: {}", path, error_text(errno));
  const auto nanoseconds = [](const timespec& t) {
    return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
  };
  return {static_cast<std::uint64_t>(status.st_size), nanoseconds(status.st_mtim),
          nanoseconds(status.st_ctim)};
}

bool folder_is_writable(const std::string& path) {
  const std::string folder = folder_of(path);
  struct stat status {};
  constexpr mode_t kAnyWrite = S_IWUSR | S_IWGRP | S_IWOTH;
  return ::stat(folder.c_str(), &status) == 0 && (status.st_mode & kAnyWrite) != 0 &&
         ::access(folder.c_str(), W_OK) == 0;
}

void write_file(const std::string& path, std::string_view bytes) {
  OutputFile file(path);
  file.write(bytes);
  file.commit();
}

bool same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return std::filesystem::equivalent(a, b, ignored);
}

}  // namespace palpate

#include <palpate/base/growing_file.h>

#include <cerrno>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>

namespace palpate {

GrowingFile::GrowingFile(std::string path, std::string_view lines) : path_(std::move(path)) {
  refuse_dash(path_);
  constexpr mode_t kPermissions = 0666;  // less the user's umask, as any program's output
  do descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, kPermissions);
  while (descriptor_ < 0 && errno == EINTR);
  if (descriptor_ < 0 && errno == EEXIST)
    throw Error("{}: exists already; move it away or give another name", path_);
  if (descriptor_ < 0) throw_file_error(path_, "open for writing", errno);
  try {
    append(lines);
  } catch (const Error&) {
    ::close(descriptor_);
    ::unlink(path_.c_str());
    throw;
  }
}

GrowingFile::~GrowingFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool GrowingFile::is_at_path() const {
  struct stat own {};
  struct stat there {};
  return ::fstat(descriptor_, &own) == 0 && ::stat(path_.c_str(), &there) == 0 &&
         own.st_dev == there.st_dev && own.st_ino == there.st_ino;
}

void GrowingFile::require_a_name() const {
  struct stat own {};
  if (!is_at_path() && ::fstat(descriptor_, &own) == 0 && own.st_nlink == 0)
    throw Error("{}: was removed while it was being written; its data is lost", path_);
}

void GrowingFile::append(std::string_view lines) {
  require_a_name();
  std::size_t done = 0;
  while (done < lines.size()) {
    const ssize_t n = ::write(descriptor_, lines.data() + done, lines.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const int error_number = n < 0 ? errno : EIO;
      size_ += lines.substr(0, done).rfind('\n') + 1;  // npos + 1 is 0
      // If this fails too, the file ends with a truncated line, which readers drop.
      [[maybe_unused]] const int ignored = ::ftruncate(descriptor_, static_cast<off_t>(size_));
      throw_file_error(path_, "write", error_number);
    }
    done += static_cast<std::size_t>(n);
  }
  size_ += done;
}

void GrowingFile::finish() {
  require_a_name();
  const bool was_moved = !is_at_path();
  const int descriptor = std::exchange(descriptor_, -1);
  const int error_number = ::fsync(descriptor) == 0 ? 0 : errno;
  if (::close(descriptor) != 0 && error_number == 0) throw_file_error(path_, "write", errno);
  if (error_number != 0) throw_file_error(path_, "write", error_number);
  if (was_moved)
    throw Error("{}: was moved while it was being written; look for it under its new name", path_);
}

}  // namespace palpate

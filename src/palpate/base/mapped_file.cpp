#include <palpate/base/mapped_file.h>

#include <cerrno>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <palpate/base/error.h>

namespace palpate {

namespace {

/// Fills `size` bytes at `to` from the beginning of a file. \returns 0, or an error number.
int read_whole(int descriptor, std::byte* to, std::size_t size) {
  std::size_t done = 0;
  while (done < size) {
    const ssize_t n = ::pread(descriptor, to + done, size - done, static_cast<off_t>(done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    if (n == 0) return ENODATA;  // it has become shorter
    done += static_cast<std::size_t>(n);
  }
  return 0;
}

void* copy_of(int descriptor, std::size_t size) {
  void* address = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (address == MAP_FAILED) return address;
  const int error_number = read_whole(descriptor, static_cast<std::byte*>(address), size);
  if (error_number == 0 && ::mprotect(address, size, PROT_READ) == 0) return address;
  ::munmap(address, size);
  errno = error_number;
  return MAP_FAILED;
}

}  // namespace

MappedFile::MappedFile(const std::string& path, FileMemory memory) : path_(path) {
  // O_NONBLOCK: opening a FIFO that nobody writes must not hang.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) throw Error("{}: cannot open: {}", path, error_text(errno));
  struct stat status {};
  const bool regular = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  const auto size = static_cast<std::size_t>(status.st_size);
  void* address = MAP_FAILED;
  if (regular && size != 0) {
    address = memory == FileMemory::kOwn ? copy_of(descriptor, size)
                                         : ::mmap(nullptr, size, PROT_READ, MAP_SHARED, descriptor, 0);
  }
  const int error_number = errno;
  ::close(descriptor);
  if (!regular) throw Error("{}: is not a regular file", path);
  if (size == 0) throw Error("{}: is empty", path);
  if (address == MAP_FAILED)
    throw Error("{}: cannot be taken into memory: {}", path, error_text(error_number));
  bytes_ = {static_cast<const std::byte*>(address), size};
}

MappedFile::~MappedFile() { ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size()); }

}  // namespace palpate

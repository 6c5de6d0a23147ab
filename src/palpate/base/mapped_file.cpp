#include <palpate/base/mapped_file.h>

#include <cerrno>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <palpate/base/error.h>
#include <palpate/base/file.h>

namespace palpate {

MappedFile::MappedFile(const std::string& path, FileMemory memory) : path_(path) {
  if (memory == FileMemory::kOwn) {
    bytes_ = copy_.emplace(path).bytes();
    return;
  }
  // O_NONBLOCK: opening a FIFO that has no writer must not block.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) throw Error("{}: cannot open: {}", path, error_text(errno));
  struct stat status {};
  const bool regular = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  const auto size = static_cast<std::size_t>(status.st_size);
  void* address = MAP_FAILED;
  if (regular && size != 0) address = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, descriptor, 0);
  const int error_number = errno;
  ::close(descriptor);
  if (!regular) throw Error("{}: is not a regular file", path);
  if (size == 0) throw Error("{}: is empty", path);
  if (address == MAP_FAILED) throw_file_error(path, "be loaded into memory", error_number);
  bytes_ = {static_cast<const std::byte*>(address), size};
}

MappedFile::~MappedFile() {
  if (!copy_) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

}  // namespace palpate

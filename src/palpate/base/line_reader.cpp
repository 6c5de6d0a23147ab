#include <palpate/base/line_reader.h>

#include <algorithm>

#include <palpate/base/error.h>

namespace palpate {
namespace {

constexpr std::size_t kReadBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxLineBytes = std::size_t{16} << 20;

}  // namespace

LineReader::LineReader(const InputFile& file, std::uint64_t offset)
    : file_(file), next_read_(offset), line_start_(offset) {}

std::optional<std::string_view> LineReader::next() {
  for (;;) {
    const std::size_t end = buffer_.find('\n', at_);
    if (end == std::string::npos && refill()) continue;
    if (at_ == buffer_.size()) return std::nullopt;
    const std::size_t length = std::min(end, buffer_.size()) - at_;
    const std::string_view line(buffer_.data() + at_, length);
    line_start_ = position();
    terminated_ = end != std::string::npos;
    ++line_number_;
    at_ = std::min(at_ + length + 1, buffer_.size());
    if (line.find_first_not_of(" \t\r") != std::string_view::npos) return line;
  }
}

void LineReader::skip_line() {
  for (;;) {
    const std::size_t end = buffer_.find('\n', at_);
    at_ = end == std::string::npos ? buffer_.size() : end + 1;
    if (end != std::string::npos || !refill()) break;
  }
  ++line_number_;
}

bool LineReader::refill() {
  if (next_read_ >= file_.size()) return false;
  if (buffer_.size() - at_ > kMaxLineBytes) {
    throw Error("{}: byte {}: a line of over {} bytes; the file is damaged", file_.path(), position(),
                kMaxLineBytes);
  }
  buffer_.erase(0, at_);
  at_ = 0;
  const std::size_t old = buffer_.size();
  buffer_.resize(old + std::min<std::uint64_t>(kReadBytes, file_.size() - next_read_));
  file_.read(next_read_, {buffer_.data() + old, buffer_.size() - old});
  next_read_ += buffer_.size() - old;
  return true;
}

}  // namespace palpate

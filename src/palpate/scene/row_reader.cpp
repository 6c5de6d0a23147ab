#include <palpate/scene/row_reader.h>

#include <algorithm>

#include <tbb/parallel_for.h>

namespace palpate {
namespace {

/// Size of a block: a quarter of the second-level cache of common processors. Unit: [byte].
constexpr std::size_t kBlockBytes = std::size_t{256} << 10;

}  // namespace

RowReader::RowReader(const InputFile& file, std::uint64_t offset, std::size_t stride)
    : file_(file), offset_(offset), stride_(stride) {}

void RowReader::read(std::uint64_t first, std::size_t n, const Decode& decode) {
  const std::uint64_t begin = offset_ + first * stride_;
  const std::size_t per_block = std::max<std::size_t>(1, kBlockBytes / stride_);
  const std::size_t blocks = (n + per_block - 1) / per_block;
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
    const std::size_t at = b * per_block;
    const std::size_t count = std::min(per_block, n - at);
    std::vector<char>& buffer = buffers_.local();
    buffer.resize(per_block * stride_);
    file_.read(begin + at * stride_, {buffer.data(), count * stride_});
    decode({buffer.data(), stride_, count}, at);
  });
}

}  // namespace palpate

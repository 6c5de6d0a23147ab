#include <palpate/scene/splat_reader.h>

#include <algorithm>
#include <limits>
#include <vector>

#include <palpate/base/error.h>
#include <palpate/scene/bytes.h>

namespace palpate {
namespace {

constexpr std::size_t kRecordBytes = 32;
constexpr std::size_t kChunkRecords = std::size_t{1} << 16;

void append(GaussianScene& scene, const char* record) {
  const auto number = [&](std::size_t k) { return load_as<float>(record + 4 * k, ByteOrder::kLittle); };
  const auto byte = [&](std::size_t k) { return static_cast<std::uint8_t>(record[k]); };
  const auto turn = [&](std::size_t k) { return (static_cast<float>(byte(k)) - 128.0F) / 128.0F; };

  scene.id.push_back(static_cast<std::uint32_t>(scene.id.size()));
  scene.position.emplace_back(number(0), number(1), number(2));
  scene.scale.emplace_back(number(3), number(4), number(5));
  scene.color.push_back({byte(24), byte(25), byte(26)});
  scene.opacity.push_back(static_cast<float>(byte(27)));
  scene.rotation.emplace_back(turn(28), turn(29), turn(30), turn(31));
}

}  // namespace

GaussianScene read_splat(const InputFile& file, const Progress& progress) {
  const std::uint64_t count = file.size() / kRecordBytes;
  if (file.size() % kRecordBytes != 0) {
    throw Error(
        "{}: byte {}: ends inside Gaussian {}; a .splat file has {} bytes a Gaussian, this one is cut",
        file.path(), file.size(), count, kRecordBytes);
  }
  if (count > std::numeric_limits<std::uint32_t>::max()) {
    throw Error("{}: holds {} Gaussians, more than 32-bit ids can count; split the file", file.path(), count);
  }
  GaussianScene scene;
  scene.source = file.path();
  scene.format = ".splat";
  scene.scale_encoding = ScaleEncoding::kLinear;
  scene.opacity_encoding = OpacityEncoding::kByte;
  scene.reserve(count);

  std::vector<char> chunk(std::min<std::uint64_t>(count, kChunkRecords) * kRecordBytes);
  for (std::uint64_t row = 0; row < count; row += kChunkRecords) {
    const std::size_t n = std::min<std::uint64_t>(kChunkRecords, count - row);
    file.read(row * kRecordBytes, {chunk.data(), n * kRecordBytes});
    for (std::size_t k = 0; k < n; ++k) append(scene, chunk.data() + k * kRecordBytes);
    report(progress, "reading", static_cast<double>(row + n) / static_cast<double>(count));
  }
  return scene;
}

}  // namespace palpate

#include <palpate/scene/splat_reader.h>

#include <limits>
#include <utility>

#include <palpate/base/error.h>
#include <palpate/scene/bytes.h>
#include <palpate/scene/row_reader.h>

namespace palpate {
namespace {

constexpr std::size_t kRecordBytes = 32;

void decode(const char* record, GaussianScene& chunk, std::size_t i) {
  const auto number = [&](std::size_t k) { return load_as<float>(record + 4 * k, ByteOrder::kLittle); };
  const auto byte = [&](std::size_t k) { return static_cast<std::uint8_t>(record[k]); };
  const auto turn = [&](std::size_t k) { return (static_cast<float>(byte(k)) - 128.0F) / 128.0F; };

  chunk.position[i] = {number(0), number(1), number(2)};
  chunk.scale[i] = {number(3), number(4), number(5)};
  chunk.color[i] = {byte(24), byte(25), byte(26)};
  chunk.opacity[i] = static_cast<float>(byte(27));
  chunk.rotation[i] = {turn(28), turn(29), turn(30), turn(31)};
}

GaussianScene describe(const std::string& path) {
  GaussianScene scene;
  scene.source = path;
  scene.format = ".splat";
  scene.scale_encoding = ScaleEncoding::kLinear;
  scene.opacity_encoding = OpacityEncoding::kByte;
  return scene;
}

class SplatReader final : public SceneReader {
 public:
  SplatReader(InputFile file, const Progress& progress)
      : SceneReader(describe(file.path()), file.size() / kRecordBytes, progress), file_(std::move(file)) {}

 private:
  void read(std::uint64_t first, GaussianScene& chunk) override {
    chunk.color.resize(chunk.size());
    rows_.read(first, chunk.size(), [&](const RowBlock& block, std::size_t at) {
      for (std::size_t k = 0; k < block.count; ++k) decode(block.row(k), chunk, at + k);
    });
  }

  std::uint64_t read_end() override { return 0; }

  InputFile file_;
  RowReader rows_{file_, 0, kRecordBytes};
};

}  // namespace

std::unique_ptr<SceneReader> open_splat(InputFile file, const Progress& progress) {
  const std::uint64_t count = file.size() / kRecordBytes;
  if (file.size() % kRecordBytes != 0) {
    throw Error(
        "{}: byte {}: ends inside Gaussian {}; a .splat file has {} bytes per Gaussian, this one is "
        "truncated",
        file.path(), file.size(), count, kRecordBytes);
  }
  if (count > std::numeric_limits<std::uint32_t>::max()) {
    throw Error("{}: holds {} Gaussians, more than 32-bit ids can count; split the file", file.path(), count);
  }
  return std::make_unique<SplatReader>(std::move(file), progress);
}

GaussianScene read_splat(InputFile file, const Progress& progress) {
  return read_all(*open_splat(std::move(file), progress));
}

}  // namespace palpate

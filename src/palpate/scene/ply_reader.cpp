#include <palpate/scene/ply_reader.h>

#include <algorithm>
#include <utility>

#include <palpate/scene/origin_survey.h>
#include <palpate/scene/ply_rows.h>
#include <palpate/scene/ply_scene.h>

namespace palpate {
namespace {

/// Finds the origin of wide positions, in a pass over all rows.
Eigen::Vector3d find_origin(const PlyScene& ply, const Progress& progress) {
  const std::uint64_t count = ply.vertex().count;
  const auto rows = open_rows(ply);
  const PlyDecoder decoder = rows->decoder();
  OriginSurvey survey(count);
  for (std::uint64_t first = 0; first < count; first += SceneReader::kChunk) {
    const std::size_t n = std::min<std::uint64_t>(SceneReader::kChunk, count - first);
    rows->next(n, [&](const RowBlock& block, std::size_t at) {
      for (std::size_t k = 0; k < block.count; ++k)
        survey.add(first + at + k, decoder.position(block.row(k)));
    });
    report(progress, kSurveyStage, static_cast<double>(first + n) / static_cast<double>(count));
  }
  return survey.origin();
}

class PlyReader final : public SceneReader {
 public:
  PlyReader(PlyScene ply, GaussianScene description, const Progress& progress)
      : SceneReader(std::move(description), ply.vertex().count, progress), ply_(std::move(ply)) {}

 private:
  void read(std::uint64_t /*first*/, GaussianScene& chunk) override {
    decoder_.size_optional(chunk);
    rows_->next(chunk.size(),
                [&](const RowBlock& block, std::size_t at) { decoder_.decode(block, chunk, at); });
  }

  std::uint64_t read_end() override { return rows_->finish(); }

  PlyScene ply_;
  std::unique_ptr<PlyRows> rows_ = open_rows(ply_);
  PlyDecoder decoder_ = rows_->decoder();
};

}  // namespace

std::unique_ptr<SceneReader> open_ply(InputFile file, const Progress& progress) {
  PlyScene ply = read_ply_scene(std::move(file));
  GaussianScene description = ply.describe();
  if (ply.layout.wide_positions) description.origin = find_origin(ply, progress);
  return std::make_unique<PlyReader>(std::move(ply), std::move(description), progress);
}

GaussianScene read_ply(InputFile file, const Progress& progress) {
  return read_all(*open_ply(std::move(file), progress));
}

}  // namespace palpate

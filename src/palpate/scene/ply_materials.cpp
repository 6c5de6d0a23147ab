#include <palpate/scene/ply_materials.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/scene/ply_rows.h>
#include <palpate/scene/ply_scene.h>
#include <palpate/scene/scene_reader.h>

namespace palpate {
namespace {

void check(const std::string& path, const std::vector<float>& values, const MaterialPropertyFormat& format) {
  const auto wrong = [most = format.most](float v) { return v < 0.0F || v > static_cast<float>(most); };
  const auto found = std::find_if(values.begin(), values.end(), wrong);
  if (found == values.end()) return;
  throw Error("{}: Gaussian {}: property '{}' is {}; it must be from 0 to {} {}, or NaN where it is not set",
              path, found - values.begin(), format.name, *found, format.most, format.unit);
}

}  // namespace

bool PlyMaterials::empty() const {
  return std::all_of(values.begin(), values.end(), [](const auto& column) { return column.empty(); });
}

PlyMaterials read_ply_materials(const std::string& path, const Progress& progress) {
  PlyMaterials materials;
  InputFile file(path);
  std::array<char, 4> start{};
  if (!is_ply({start.data(), file.read_some(0, start)})) return materials;
  const PlyScene ply = read_ply_scene(std::move(file));
  if (ply.layout.materials.empty()) return materials;

  const std::uint64_t count = ply.vertex().count;
  const auto rows = open_rows(ply);
  const PlyDecoder decoder = rows->decoder();
  decoder.size(materials, count);
  for (std::uint64_t first = 0; first < count; first += SceneReader::kChunk) {
    const std::size_t n = std::min<std::uint64_t>(SceneReader::kChunk, count - first);
    rows->next(n,
               [&](const RowBlock& block, std::size_t at) { decoder.decode(block, materials, first + at); });
    report(progress, "reading materials", static_cast<double>(first + n) / static_cast<double>(count));
  }
  for (std::size_t p = 0; p < kMaterialPropertyCount; ++p)
    check(path, materials.values[p], kMaterialProperties[p]);
  return materials;
}

}  // namespace palpate

#include <palpate/scene/ply_reader.h>

#include <limits>
#include <utility>

#include <palpate/base/error.h>
#include <palpate/scene/ply_layout.h>
#include <palpate/scene/ply_scene.h>

namespace palpate {
namespace {

/// The index of the element `vertex`.
std::size_t find_vertex(const InputFile& file, const PlyHeader& header) {
  for (std::size_t i = 0; i < header.elements.size(); ++i) {
    const PlyElement& element = header.elements[i];
    if (element.name != "vertex") continue;
    if (element.count == 0)
      throw Error("{}: holds no Gaussians ('element vertex 0'); train or export it again", file.path());
    if (element.count > std::numeric_limits<std::uint32_t>::max()) {
      throw Error(
          "{}: claims {} Gaussians, more than 32-bit ids can count; the header is wrong or the file must be "
          "split",
          file.path(), element.count);
    }
    return i;
  }
  throw Error("{}: has no element 'vertex'; it is not a Gaussian splatting scene", file.path());
}

}  // namespace

GaussianScene PlyScene::describe() const {
  GaussianScene scene;
  scene.source = file.path();
  scene.sh_degree = layout.sh_degree;
  scene.format =
      fmt::format("{} .ply, {}, SH degree {}", layout.variant, to_string(header.encoding), scene.sh_degree);
  return scene;
}

std::unique_ptr<SceneReader> open_ply(InputFile file, const Progress& progress) {
  PlyHeader header = read_ply_header(file);
  const std::size_t vertex = find_vertex(file, header);
  PlyLayout layout = check_layout(file.path(), header.elements[vertex]);
  const auto open = header.encoding == PlyEncoding::kAscii ? open_ascii_ply : open_binary_ply;
  return open({std::move(file), std::move(header), vertex, std::move(layout)}, progress);
}

GaussianScene read_ply(InputFile file, const Progress& progress) {
  return read_all(*open_ply(std::move(file), progress));
}

}  // namespace palpate

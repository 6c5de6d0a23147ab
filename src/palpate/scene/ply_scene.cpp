#include <palpate/scene/ply_scene.h>

#include <limits>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/error.h>

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

PlyScene read_ply_scene(InputFile file) {
  PlyHeader header = read_ply_header(file);
  const std::size_t vertex = find_vertex(file, header);
  PlyLayout layout = check_layout(file.path(), header.elements[vertex]);
  return {std::move(file), std::move(header), vertex, std::move(layout)};
}

GaussianScene PlyScene::describe() const {
  GaussianScene scene;
  scene.source = file.path();
  scene.sh_degree = layout.sh_degree;
  scene.format =
      fmt::format("{} .ply, {}, SH degree {}", layout.variant, to_string(header.encoding), scene.sh_degree);
  if (!layout.materials.empty()) scene.format += fmt::format(", with {}", fmt::join(layout.materials, ", "));
  return scene;
}

}  // namespace palpate

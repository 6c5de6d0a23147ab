#include <palpate/scene/ply_writer.h>

#include <array>
#include <cstddef>
#include <vector>

#include <fmt/core.h>

#include <palpate/base/file.h>
#include <palpate/scene/ply_row.h>
#include <palpate/scene/sh_color.h>

namespace palpate {
namespace {

constexpr std::array kProperties{"x",       "y",      "z",      "nx",      "ny",      "nz",
                                 "f_dc_0",  "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1",
                                 "scale_2", "rot_0",  "rot_1",  "rot_2",   "rot_3"};

std::string ply_header(std::size_t count, const std::string& comment, const PlyMaterials& materials) {
  std::string header =
      fmt::format("ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {}\n", comment, count);
  for (const char* name : kProperties) header += fmt::format("property float {}\n", name);
  for (std::size_t k = 0; k < kMaterialPropertyCount; ++k) {
    if (!materials.values[k].empty())
      header += fmt::format("property float {}\n", kMaterialProperties[k].name);
  }
  return header + "end_header\n";
}

void append_row(std::string& out, const GaussianScene& scene, const PlyMaterials& materials, std::size_t i) {
  const Gaussian g = scene.gaussian(i);
  for (const double v : g.position) append_float(out, v);
  for (int k = 0; k < 3; ++k) append_float(out, 0.0);
  for (std::size_t k = 0; k < 3; ++k) {
    append_float(out, scene.color.empty() ? 0.0 : sh_from_color(scene.color[i][k]));
  }
  append_shape(out, g);
  for (const std::vector<float>& column : materials.values) {
    if (!column.empty()) append_float(out, column[i]);
  }
}

}  // namespace

void write_ply(const GaussianScene& scene, const std::string& path, const std::string& comment,
               const PlyMaterials& materials) {
  OutputFile file(path);
  file.write(ply_header(scene.size(), comment, materials));
  std::string row;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    row.clear();
    append_row(row, scene, materials, i);
    file.write(row);
  }
  file.commit();
}

std::string ply_bytes(const GaussianScene& scene, const std::string& comment) {
  const PlyMaterials none;
  std::string bytes = ply_header(scene.size(), comment, none);
  for (std::size_t i = 0; i < scene.size(); ++i) append_row(bytes, scene, none, i);
  return bytes;
}

}  // namespace palpate

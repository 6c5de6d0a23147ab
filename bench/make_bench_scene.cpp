// Writes the benchmark scene as a binary .ply of any size, chunk by chunk.
#include <algorithm>
#include <bit>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <palpate/base/file.h>

#include "bench_scene.h"
#include "program.h"

namespace palpate::bench {
namespace {

static_assert(std::endian::native == std::endian::little, "rows are written as they lie in memory");

constexpr std::size_t kChunk = 1 << 18;  // rows in memory at a time: 15 MB

std::string header(std::size_t n) {
  std::string text = fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", n);
  for (const char* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1",
                           "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    text += fmt::format("property float {}\n", name);
  }
  return text + "end_header\n";
}

void write_scene(const BenchScene& scene, const std::string& path) {
  OutputFile file(path);
  file.write(header(scene.size()));
  std::vector<BenchGaussian> rows;
  for (std::size_t begin = 0; begin < scene.size(); begin += rows.size()) {
    rows.resize(std::min(kChunk, scene.size() - begin));
    tbb::parallel_for(std::size_t{0}, rows.size(),
                      [&](std::size_t i) { rows[i] = scene.gaussian(begin + i); });
    file.write({reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(BenchGaussian)});
  }
  file.commit();
}

}  // namespace
}  // namespace palpate::bench

int main(int argc, char** argv) {
  using namespace palpate::bench;
  CLI::App app("Writes the benchmark scene as a .ply.", "make_bench_scene");
  std::size_t n = 0;
  std::uint64_t seed = 1;
  std::string path;
  app.add_option("gaussians", n, "number of Gaussians")->required()->check(positive());
  app.add_option("out", path, "file to write")->required()->type_name("OUT.ply");
  app.add_option("--seed", seed, "of the scene")->capture_default_str();
  return run_program(app, argc, argv, [&] { write_scene(BenchScene(n, seed), path); });
}

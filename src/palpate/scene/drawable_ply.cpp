#include <palpate/scene/drawable_ply.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <palpate/base/file.h>
#include <palpate/scene/ply_row.h>
#include <palpate/scene/ply_rows.h>
#include <palpate/scene/ply_scene.h>
#include <palpate/scene/scene_reader.h>

namespace palpate {
namespace {

/// Largest header that the viewer reads. Unit: [bytes].
constexpr std::uint64_t kMostHeader = 65536;
/// Largest SH degree that it draws.
constexpr int kMostDegree = 3;

bool is_plain_line(std::string_view line) {
  constexpr std::array<std::string_view, 4> kBegins{"comment", "element vertex ", "property float ",
                                                    "end_header"};
  return line.empty() || line == "ply" || line == "format binary_little_endian 1.0" ||
         std::any_of(kBegins.begin(), kBegins.end(), [&](auto begin) { return line.starts_with(begin); });
}

/// Returns whether the header has nothing but lines that the viewer knows, in its spelling.
bool is_plain_header(const PlyScene& ply) {
  if (ply.header.data_offset > kMostHeader) return false;
  std::string text(ply.header.data_offset, '\0');
  ply.file.read(0, text);
  const auto is_text = [](char c) { return c == '\n' || (c >= ' ' && c <= '~'); };
  if (!std::all_of(text.begin(), text.end(), is_text)) return false;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\n'), rest.size() - 1);
    if (!is_plain_line(rest.substr(0, end))) return false;
    rest.remove_prefix(end + 1);
  }
  return true;
}

int drawn_degree(const PlyScene& ply) { return std::min(ply.layout.sh_degree, kMostDegree); }

/// Number of f_rest_* of a degree.
std::size_t rest_count(int degree) {
  const std::size_t side = static_cast<std::size_t>(degree) + 1;
  return 3 * (side * side - 1);
}

std::vector<std::string> properties(int degree) {
  std::vector<std::string> names{"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2"};
  for (std::size_t k = 0; k < rest_count(degree); ++k) names.push_back(fmt::format("f_rest_{}", k));
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    names.emplace_back(name);
  return names;
}

std::string header_of(const PlyScene& ply) {
  std::string text =
      fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", ply.vertex().count);
  for (const std::string& name : properties(drawn_degree(ply)))
    text += fmt::format("property float {}\n", name);
  return text + "end_header\n";
}

}  // namespace

bool is_drawable(const std::string& path) {
  InputFile file(path);
  std::array<char, 4> start{};
  if (!is_ply({start.data(), file.read_some(0, start)})) return true;
  const PlyScene ply = read_ply_scene(std::move(file));
  return is_plain_header(ply) && ply.header.elements.size() == 1 && ply.layout.variant == "INRIA" &&
         ply.vertex().find(kPlyFieldNames[kRed]) && ply.layout.sh_degree <= kMostDegree;
}

std::uint64_t drawable_ply_bytes(const std::string& path) {
  const PlyScene ply = read_ply_scene(InputFile(path));
  return kMostHeader + ply.vertex().count * sizeof(float) * properties(drawn_degree(ply)).size();
}

void write_drawable_ply(const std::string& from, const std::string& to) {
  const auto reader = open_scene(from);
  const PlyScene ply = read_ply_scene(InputFile(from));  // for the colours, which the reader does not keep
  const auto rows = open_rows(ply);
  const PlyDecoder decoder = rows->decoder();
  const int degree = drawn_degree(ply);
  const std::size_t colors = 3 + rest_count(degree);
  OutputFile file(to);
  file.write(header_of(ply));
  GaussianScene chunk;
  std::vector<float> sh;
  std::string bytes;
  while (reader->next(chunk)) {
    sh.assign(chunk.size() * colors, 0.0F);
    rows->next(chunk.size(), [&](const RowBlock& block, std::size_t at) {
      decoder.decode_sh(block, degree, sh.data() + at * colors);
    });
    bytes.clear();
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      const Gaussian g = chunk.gaussian(i);
      for (const double v : g.position) append_float(bytes, v);
      for (std::size_t k = 0; k < colors; ++k) append_float(bytes, sh[i * colors + k]);
      append_shape(bytes, g);
    }
    file.write(bytes);
  }
  file.commit(OutputFile::Sync::kNo);
}

}  // namespace palpate

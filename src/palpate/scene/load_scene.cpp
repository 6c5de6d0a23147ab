#include <palpate/scene/load_scene.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string_view>

#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/scene/ply_reader.h>
#include <palpate/scene/splat_reader.h>

namespace palpate {
namespace {

struct ForeignFormat {
  std::string_view magic;
  std::string_view name;
};

/// Formats that carry splats but are not read; told apart so that the message can say so.
constexpr std::array kForeignFormats{
    ForeignFormat{"\x1f\x8b", "a gzip file (SPZ up to version 3)"},
    ForeignFormat{"NGSP", "an SPZ file"},
    ForeignFormat{"PK\x03\x04", "a zip file (SOG)"},
    ForeignFormat{"glTF", "a binary glTF file"},
    ForeignFormat{"{", "a JSON file (SOG metadata or glTF)"},
};

std::string lower_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

}  // namespace

GaussianScene load_scene(const std::string& path, const Progress& progress) {
  const InputFile file(path);
  if (file.size() == 0) throw Error("{}: is empty; give a 3DGS .ply or .splat file", path);
  std::array<char, 8> head{};
  const std::size_t n = file.read_some(0, head);
  const std::string_view start(head.data(), n);

  if (is_ply(start)) return read_ply(file, progress);
  const std::string extension = lower_extension(path);
  if (extension == ".splat") return read_splat(file, progress);
  for (const ForeignFormat& foreign : kForeignFormats) {
    if (start.starts_with(foreign.magic)) {
      throw Error("{}: is {}, which cannot be read; convert it to .ply first", path, foreign.name);
    }
  }
  if (extension == ".ply") {
    throw Error("{}: byte 0: does not begin with 'ply'; it is not a .ply file", path);
  }
  throw Error("{}: is neither .ply nor .splat, by its content or its extension", path);
}

}  // namespace palpate

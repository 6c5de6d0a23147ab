#include <palpate/scene/scene_reader.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <numeric>
#include <string_view>
#include <utility>

#include <palpate/base/append.h>
#include <palpate/base/error.h>
#include <palpate/base/file.h>
#include <palpate/scene/ply_reader.h>
#include <palpate/scene/ply_scene.h>
#include <palpate/scene/splat_reader.h>

namespace palpate {
namespace {

struct ForeignFormat {
  std::string_view magic;
  std::string_view name;
};

/// Splat formats that are not supported, detected for the error message.
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

void append(GaussianScene& scene, const GaussianScene& chunk) {
  palpate::append(scene.id, chunk.id);
  palpate::append(scene.position, chunk.position);
  palpate::append(scene.scale, chunk.scale);
  palpate::append(scene.rotation, chunk.rotation);
  palpate::append(scene.opacity, chunk.opacity);
  palpate::append(scene.filter_3d, chunk.filter_3d);
  palpate::append(scene.color, chunk.color);
}

}  // namespace

SceneReader::SceneReader(GaussianScene description, std::uint64_t count, Progress progress)
    : description_(std::move(description)), count_(count), progress_(std::move(progress)) {}

bool SceneReader::next(GaussianScene& chunk) {
  chunk = description_;
  if (done_ == count_) {
    if (!std::exchange(ended_, true)) description_.trailing_bytes = read_end();
    return false;
  }
  const std::size_t n = std::min<std::uint64_t>(kChunk, count_ - done_);
  chunk.id.resize(n);
  std::iota(chunk.id.begin(), chunk.id.end(), static_cast<std::uint32_t>(done_));
  chunk.position.resize(n);
  chunk.scale.resize(n);
  chunk.rotation.resize(n);
  chunk.opacity.resize(n);
  read(done_, chunk);
  done_ += n;
  report(progress_, "reading", static_cast<double>(done_) / static_cast<double>(count_));
  return true;
}

void check_beginning(const std::string& path) {
  InputFile file(path);
  std::array<char, 4> start{};
  if (is_ply({start.data(), file.read_some(0, start)})) {
    read_ply_scene(std::move(file));
  } else {
    open_scene(path);
  }
}

std::unique_ptr<SceneReader> open_scene(const std::string& path, const Progress& progress) {
  InputFile file(path);
  if (file.size() == 0) throw Error("{}: is empty; give a 3DGS .ply or .splat file", path);
  std::array<char, 8> head{};
  const std::size_t n = file.read_some(0, head);
  const std::string_view start(head.data(), n);

  if (is_ply(start)) return open_ply(std::move(file), progress);
  const std::string extension = lower_extension(path);
  if (extension == ".splat") return open_splat(std::move(file), progress);
  for (const ForeignFormat& foreign : kForeignFormats) {
    if (start.starts_with(foreign.magic)) {
      throw Error(
          "{}: is {}, which cannot be read; convert it to .ply first, for example with npx "
          "@playcanvas/splat-transform",
          path, foreign.name);
    }
  }
  if (extension == ".ply") {
    throw Error("{}: byte 0: does not begin with 'ply'; it is not a .ply file", path);
  }
  throw Error("{}: is neither .ply nor .splat, by its content or its extension", path);
}

GaussianScene read_all(SceneReader& reader) {
  GaussianScene scene = reader.description();
  scene.reserve(reader.count());
  GaussianScene chunk;
  while (reader.next(chunk)) append(scene, chunk);
  scene.trailing_bytes = reader.description().trailing_bytes;
  return scene;
}

}  // namespace palpate

// Index files: for any bytes, IndexFile either throws Error or returns the index that was written, which can
// be queried. The input is a list of changes to a valid index, or the file itself if it begins like an index.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

#include <palpate/base/error.h>
#include <palpate/collision/index_file.h>
#include <palpate/study/procedural.h>

#include "input_file.h"

namespace {

using palpate::fuzz::require;

constexpr const char* kOptions = "--sigma 1";

/// A scene file, which only has to exist, and the bytes of a valid index of it.
struct Sound {
  palpate::fuzz::InputFile scene_file;
  std::string scene = scene_file.hold(reinterpret_cast<const std::uint8_t*>("x"), 1, "scene.ply");
  std::string bytes;

  Sound() {
    const palpate::GaussianScene gaussians =
        palpate::make_scene(*palpate::make_surface("sphere"), {.spacing = 0.03});
    const palpate::SceneIndex index(gaussians, {}, {});
    const std::string path = scene.substr(0, scene.rfind('/')) + "/sound.palpate";
    palpate::IndexWriter writer(path);
    writer.add(index.view().blocks);
    palpate::IndexDescription description;
    description.source = {palpate::stamp_of(scene), palpate::content_hash(scene)};
    description.options = kOptions;
    description.gaussians = index.size();
    writer.finish(index.view().nodes, description);
    std::ifstream in(path, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
    require(bytes.size() > 8192);
  }
};

void use(const std::string& path, const std::string& scene) {
  const auto file = std::make_shared<palpate::IndexFile>(path, scene, kOptions);
  const palpate::SceneIndex index(file, {});
  palpate::ContactSet contacts;
  for (const double x : {0.0, 0.05, 0.15}) {
    const palpate::Pose pose{{x, 0.0, 0.0}, Eigen::Quaterniond::Identity()};
    index.query(palpate::Ellipsoid::from_semi_axes(pose, {0.02, 0.02, 0.04}), contacts);
    require(contacts.filtered <= contacts.candidates && contacts.contacts.size() <= contacts.filtered);
  }
}

/// Applies records of three bytes position and one byte value; three remaining bytes are a new length.
std::string changed(std::string bytes, const std::uint8_t* data, std::size_t size) {
  for (; size >= 4; data += 4, size -= 4) {
    const std::size_t at = (std::size_t{data[0]} << 16 | std::size_t{data[1]} << 8 | data[2]) % bytes.size();
    bytes[at] = static_cast<char>(data[3]);
  }
  if (size == 3)
    bytes.resize((std::size_t{data[0]} << 16 | std::size_t{data[1]} << 8 | data[2]) % (bytes.size() + 1));
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Sound sound;
  static palpate::fuzz::InputFile file;
  const bool whole = size >= 8 && std::memcmp(data, sound.bytes.data(), 8) == 0;
  const std::string bytes =
      whole ? std::string(reinterpret_cast<const char*>(data), size) : changed(sound.bytes, data, size);
  try {
    use(file.hold(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), "scene.ply.palpate"),
        sound.scene);
    require(bytes == sound.bytes);  // a changed file must not be accepted
  } catch (const palpate::Error&) {
  }
  return 0;
}

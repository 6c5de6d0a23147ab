#include <palpate/scene/load_scene.h>

#include <palpate/scene/scene_reader.h>

namespace palpate {

GaussianScene load_scene(const std::string& path, const Progress& progress) {
  return read_all(*open_scene(path, progress));
}

}  // namespace palpate

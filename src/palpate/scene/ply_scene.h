/// \file
/// A .ply whose header is that of a Gaussian splatting scene, and the readers of its data.
#pragma once

#include <cstdint>
#include <memory>

#include <palpate/base/file.h>
#include <palpate/base/progress.h>
#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/ply_decoder.h>
#include <palpate/scene/ply_header.h>
#include <palpate/scene/ply_layout.h>
#include <palpate/scene/scene_reader.h>

namespace palpate {

struct PlyScene {
  InputFile file;
  PlyHeader header;
  std::size_t vertex_index;  ///< of the element `vertex`
  PlyLayout layout;

  const PlyElement& vertex() const { return header.elements[vertex_index]; }

  /// See SceneReader::description(); the origin is not known yet.
  GaussianScene describe() const;
};

/// Checks everything that can be checked without reading the Gaussians, unless positions are wide.
/// \throws Error for data before `vertex` that are broken, or too little data for its rows.
std::unique_ptr<SceneReader> open_binary_ply(PlyScene ply, const Progress& progress);
std::unique_ptr<SceneReader> open_ascii_ply(PlyScene ply, const Progress& progress);

}  // namespace palpate

/// \file
/// A .ply file with the header of a Gaussian splatting scene.
#pragma once

#include <cstddef>

#include <palpate/base/file.h>
#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/ply_header.h>
#include <palpate/scene/ply_layout.h>

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

/// Reads the header. \throws Error if it is malformed or not that of a scene of at least one Gaussian.
PlyScene read_ply_scene(InputFile file);

}  // namespace palpate

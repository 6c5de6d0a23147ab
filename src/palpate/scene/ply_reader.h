/// \file
/// Reader of Gaussian splatting scenes in .ply, in all common variants.
#pragma once

#include <memory>

#include <palpate/base/file.h>
#include <palpate/base/progress.h>
#include <palpate/scene/ply_header.h>
#include <palpate/scene/scene_reader.h>

namespace palpate {

/// Reads the element `vertex` of a .ply whose properties are INRIA's, in any order and of any
/// numeric type, in ASCII or binary of either byte order:
///
///     x y z                    mean, required
///     scale_0 scale_1 scale_2  log of sigma, required; 2DGS has no scale_2, its sigma z is 0
///     rot_0 .. rot_3           quaternion w, x, y, z, required
///     opacity                  logit, required
///     filter_3D                Mip-Splatting's 3D filter, applied by GaussianScene::gaussian()
///     f_dc_0 .. f_dc_2         SH constant term, for colour
///     f_rest_0 ..              higher SH: counted, not kept; the count must be that of a degree
///     stiffness friction
///     damping                  material properties; left to read_ply_materials()
///     anything else            ignored (nx ny nz among them)
///
/// Other elements, before and after `vertex`, are skipped; bytes after the data are counted. Values wider
/// than single precision are rounded to it, positions relative to GaussianScene::origin. \throws Error for a
/// malformed header, a missing property, a truncated file, or an invalid number.
std::unique_ptr<SceneReader> open_ply(InputFile file, const Progress& progress = {});

/// Reads the whole scene.
GaussianScene read_ply(InputFile file, const Progress& progress = {});

}  // namespace palpate

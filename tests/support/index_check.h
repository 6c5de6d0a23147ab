/// \file
/// Whether an index is what it should be, found by walking it.
#pragma once

#include <palpate/collision/index_layout.h>
#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/scene_filter.h>

namespace palpate::test {

/// Expects of `view`, the index of `scene` under `filter` (unregistered rules only):
///   - a tree: every node and every block has one parent, depth at most kMaxIndexDepth;
///   - every Gaussian that is kept in exactly one lane, with the numbers of filter_scene(), ids increasing in
///   a block;
///   - every box contains the ellipsoids, and the boxes, below it;
///   - arrays aligned as the vector instructions want them.
/// \returns the depth: 1 for a root alone.
std::size_t expect_valid(const IndexView& view, const GaussianScene& scene, const SceneFilter& filter = {});

}  // namespace palpate::test

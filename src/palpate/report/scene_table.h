/// \file
/// Content, defects and filter result of a scene file, as text and JSON.
#pragma once

#include <string>

#include <palpate/report/ordered_json.h>
#include <palpate/scene/gaussian_scene.h>
#include <palpate/scene/lint.h>
#include <palpate/scene/scene_filter.h>

namespace palpate {

/// A scene with its filter and lint reports.
struct SceneReport {
  const GaussianScene& scene;
  const EllipsoidScene& kept;  ///< in the world frame
  const FilterReport& filtered;
  const LintReport& lint;
  double opacity_min;  ///< of the filter
  std::string frame;   ///< assumptions about the captured frame
  double scale;        ///< of the registration. Unit: [m/unit].
};

OrderedJson scene_json(const SceneReport& report);
std::string scene_text(const SceneReport& report);

}  // namespace palpate

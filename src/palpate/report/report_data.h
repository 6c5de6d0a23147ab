/// \file
/// JSON document of the report page.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <palpate/collision/scene_index.h>
#include <palpate/haptics/tool.h>
#include <palpate/record/run_log.h>
#include <palpate/scene/scene_filter.h>

namespace palpate {

/// Contacts of a run, recomputed in its scene for evenly selected rows, so few that a page can draw them.
struct RunContacts {
  struct Point {
    std::size_t row;  ///< of the run
    Contact contact;
  };
  std::vector<Point> points;
  std::size_t rows_checked = 0;
  std::size_t rows_differing = 0;  ///< whose number of contacts is not that of the run
};

/// Queries the poses of `run` in contact; an even selection of a few thousand if there are more.
RunContacts find_contacts(const Run& run, const SceneIndex& index, const Tool& tool);

/// Returns the document of the report page (read by web/report/src/data.js). `scene`, `tool` and `contacts`
/// may be null if the run's scene is not available. Long runs are thinned, which the summary states. \param
/// version of the program, which the page names \param others runs that are drawn over it
std::string report_json(const Run& run, const EllipsoidScene* scene, const Tool* tool,
                        const RunContacts* contacts, const std::string& version,
                        std::span<const Run> others = {});

}  // namespace palpate

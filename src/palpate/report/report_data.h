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

/// Contacts of a run, found again in its scene: an even selection that a page can draw.
struct RunContacts {
  struct Point {
    std::size_t row;  ///< of the run
    Contact contact;
  };
  std::vector<Point> points;
  std::size_t rows_checked = 0;
  std::size_t rows_differing = 0;  ///< where the number of contacts is not the run's
};

/// Queries the poses of `run` that are in contact, at most some thousands of them, evenly.
RunContacts find_contacts(const Run& run, const SceneIndex& index, const Tool& tool);

/// The document of the report page (web/report/src/data.js reads it). `index`, `tool` and `contacts` may be
/// null where the run's scene is not at hand. Long runs are thinned; the text says so. \param version of the
/// program, which the page names \param others runs that are drawn over it
std::string report_json(const Run& run, const EllipsoidScene* scene, const Tool* tool,
                        const RunContacts* contacts, const std::string& version,
                        std::span<const Run> others = {});

}  // namespace palpate

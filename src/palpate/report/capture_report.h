/// \file
/// Tables and figures of an evaluation on a captured scene.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <palpate/base/progress.h>
#include <palpate/record/trajectory.h>
#include <palpate/report/figure_column.h>
#include <palpate/report/ordered_json.h>
#include <palpate/report/plot.h>
#include <palpate/study/capture_evaluation.h>

namespace palpate {

/// Results of one model.
struct CaptureRow {
  std::string model;
  CaptureFigures figures;
  std::optional<CaptureLikeness> likeness;
  std::vector<CapturePush> pushes;
};

/// Pushes along all aims, and slides along the first so many of them. \param model its name
CaptureRow capture_row(const std::string& model, CaptureEvaluation& evaluation,
                       const std::vector<CaptureAim>& aims, std::size_t slides,
                       const Progress& progress = {});

/// The poses of a push, 1 ms each.
Trajectory capture_trajectory(const std::vector<CaptureTick>& ticks);

/// The figures of a row, whose headings say what they are.
const std::vector<FigureColumn<CaptureRow>>& capture_columns();

/// \name All rows
/// @{
std::string capture_text(const std::vector<CaptureRow>& rows);  ///< a table for a terminal, a column a row
OrderedJson capture_json(const std::vector<CaptureRow>& rows);
std::string capture_csv(const std::vector<CaptureRow>& rows);
std::string capture_html(const std::vector<CaptureRow>& rows);  ///< a table for page_document()
/// @}

/// Numbers of the worst five pushes, the worst first: whose force begins farthest from the seen surface.
std::vector<std::size_t> worst_pushes(const std::vector<CapturePush>& pushes);

/// Seen surface, tool and proxy in the plane of the push that has most of what is aside in it.
Plot capture_path_plot(const std::string& name, const CapturePush& push,
                       const std::vector<CaptureTick>& ticks, const SeenSurface& seen, const Tool& tool);

/// Force over depth, in and back. \param stiffness Unit: [N/m].
Plot capture_force_plot(const std::string& name, const std::vector<CaptureTick>& ticks, double stiffness);

}  // namespace palpate

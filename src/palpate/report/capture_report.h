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

/// Runs a push along each aim, and a slide along each of the first `slides` of them. \param model its name
CaptureRow capture_row(const std::string& model, CaptureEvaluation& evaluation,
                       const std::vector<CaptureAim>& aims, std::size_t slides,
                       const Progress& progress = {});

/// Poses of the tool in a push, 1 ms apart.
Trajectory capture_trajectory(const std::vector<CaptureTick>& ticks);

/// Columns of a row; their headings define the figures.
const std::vector<FigureColumn<CaptureRow>>& capture_columns();

/// \name All rows
/// @{
std::string capture_text(const std::vector<CaptureRow>& rows);  ///< a text table, one column per row
OrderedJson capture_json(const std::vector<CaptureRow>& rows);
std::string capture_csv(const std::vector<CaptureRow>& rows);
std::string capture_html(const std::vector<CaptureRow>& rows);  ///< an HTML table for page_document()
/// @}

/// Indices of the five worst pushes, worst first: those whose force begins farthest from the seen surface.
std::vector<std::size_t> worst_pushes(const std::vector<CapturePush>& pushes);

/// Plots seen surface, tool and proxy in a plane through the push.
Plot capture_path_plot(const std::string& name, const CapturePush& push,
                       const std::vector<CaptureTick>& ticks, const SeenSurface& seen, const Tool& tool);

/// Plots force over depth, on the way in and back. \param stiffness Unit: [N/m].
Plot capture_force_plot(const std::string& name, const std::vector<CaptureTick>& ticks, double stiffness);

}  // namespace palpate

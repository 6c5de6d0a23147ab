/// \file
/// Tables of an evaluation against analytic surfaces, as text, CSV and JSON.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <palpate/report/figure_column.h>
#include <palpate/report/ordered_json.h>
#include <palpate/study/crossings.h>
#include <palpate/study/evaluation.h>

namespace palpate {

/// Results of one model on one shape at one spacing.
struct EvaluationRow {
  std::string shape, model;
  double spacing;  ///< Unit: [m].
  Evaluation figures;
  std::optional<StepResponse> step = {};        ///< if the shape is `step`
  std::optional<StepResponse> clean_step = {};  ///< the same without noise
  std::optional<EdgeResponse> edge = {};        ///< if the shape is `box`
  Curve friction_at = {};                       ///< over the nominal coefficient; empty without friction
  std::optional<Spread> denser = {};            ///< |F| over that at the first spacing; unset at the first
};

/// Runs all measurements for the shape of `setup`. \param model its name
EvaluationRow evaluation_row(const EvaluationSetup& setup, const std::string& model,
                             const Progress& progress = {});

/// Compares the forces of every row with those at the first spacing.
void compare_densities(std::vector<EvaluationRow>& rows, double first_spacing);

using EvaluationColumn = FigureColumn<EvaluationRow>;

/// A printed table of some columns, and of the rows that have values in them.
struct EvaluationSection {
  const char* title;
  const char* note;  ///< explanation of the figures, in a few lines
  std::vector<EvaluationColumn> columns;

  bool has(const EvaluationRow& row) const;
};

/// All columns, in order.
const std::vector<EvaluationSection>& evaluation_sections();

std::string evaluation_text(const std::vector<EvaluationRow>& rows);

/// Returns one object per row: all columns, and the curves measured along a path.
OrderedJson evaluation_json(const std::vector<EvaluationRow>& rows);

/// Returns one line per row.
std::string evaluation_csv(const std::vector<EvaluationRow>& rows);

}  // namespace palpate

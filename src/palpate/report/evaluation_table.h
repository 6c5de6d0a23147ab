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

/// One model on one shape at one spacing.
struct EvaluationRow {
  std::string shape, model;
  double spacing;  ///< Unit: [m].
  Evaluation figures;
  std::optional<StepResponse> step = {};        ///< where the shape is `step`
  std::optional<StepResponse> clean_step = {};  ///< the same without noise
  std::optional<EdgeResponse> edge = {};        ///< where it is `box`
  Curve friction_at = {};                       ///< over the coefficient; empty if the model has none
  std::optional<Spread> denser = {};            ///< |F| over that at the first spacing; not there itself
};

/// Runs all measurements for the shape of `setup`. \param model its name
EvaluationRow evaluation_row(const EvaluationSetup& setup, const std::string& model,
                             const Progress& progress = {});

/// Compares the forces of every row with those at the first spacing.
void compare_densities(std::vector<EvaluationRow>& rows, double first_spacing);

using EvaluationColumn = FigureColumn<EvaluationRow>;

/// A table of some columns for people, with the rows that have something in it.
struct EvaluationSection {
  const char* title;
  const char* note;  ///< what the figures are, in a few lines
  std::vector<EvaluationColumn> columns;

  bool has(const EvaluationRow& row) const;
};

/// All columns, in order.
const std::vector<EvaluationSection>& evaluation_sections();

std::string evaluation_text(const std::vector<EvaluationRow>& rows);

/// One object a row, with the columns, and the curves of what was measured along a way.
OrderedJson evaluation_json(const std::vector<EvaluationRow>& rows);

/// One line a row.
std::string evaluation_csv(const std::vector<EvaluationRow>& rows);

}  // namespace palpate

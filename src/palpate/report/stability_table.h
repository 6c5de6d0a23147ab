/// \file
/// Tables of stability trials, as text, CSV and JSON.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <palpate/report/ordered_json.h>
#include <palpate/study/stability_study.h>

namespace palpate {

/// Factor from SI units to those of the tables: ms, mm, mJ.
inline constexpr double kMilli = 1e3;

/// "0.1 kg, 3 N s/m, 300 N/m"
std::string hand_text(const HandProperties& hand);

/// Worst results over all hands, for one profile, model and source.
struct StabilitySummary {
  const StabilityRow* any;  ///< one of its rows, for the names
  double limit_cycle = 0.0, port_energy = 0.0, force_off = 0.0;
  int contact_changes = 0;
  std::optional<double> z_low, z_high;
};
std::vector<StabilitySummary> summarize(const std::vector<StabilityRow>& rows);

OrderedJson stability_json(const StabilityTables& tables);
std::string stability_csv(const StabilityTables& tables);
std::string stability_text(const StabilityTables& tables);

}  // namespace palpate
